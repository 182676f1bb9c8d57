// The settings: a form made from the table of parameters of the library, and what it says as a request and as a command line.

const $ = (id) => document.getElementById(id);

/// Makes the form. `methods` is the table; `onChange` is called when something is changed.
export class Settings {
  constructor(methods, first, onChange) {
    this.methods = methods;
    this.onChange = onChange;
    $('method-name').replaceChildren(...methods.map((method) => new Option(method.name, method.name)));
    $('method-name').value = first;
    this.first = first;
    this.values = {};
    $('method').addEventListener('change', (event) => {
      if (event.target === $('method-name')) this.build();
      onChange();
    });
    this.build();
  }

  get method() {
    return this.methods.find((method) => method.name === $('method-name').value);
  }

  build() {
    this.values = {};
    $('method-summary').textContent = `${this.method.summary}.`;
    // Files of weights are for the command line.
    const shown = this.method.parameters.filter((parameter) => parameter.kind !== 'text');
    $('parameters').replaceChildren(...shown.map((parameter) => this.row(parameter)));
  }

  set(parameter, value) {
    const isDefault = JSON.stringify(value) === JSON.stringify(parameter.default);
    if (isDefault) delete this.values[parameter.name];
    else this.values[parameter.name] = value;
  }

  row(parameter) {
    const label = document.createElement('label');
    label.className = 'row';
    label.title = parameter.help + (parameter.unit ? `, in ${parameter.unit}` : '');
    const name = document.createElement('span');
    name.textContent = parameter.label;
    label.append(name, this.widget(parameter));
    const hint = document.createElement('p');
    hint.className = 'hint';
    hint.textContent = label.title;
    const both = document.createElement('div');
    both.append(label, hint);
    return both;
  }

  widget(parameter) {
    if (parameter.kind === 'count' || parameter.kind === 'number') return this.number(parameter);
    const select = document.createElement('select');
    select.dataset.parameter = parameter.name;
    if (parameter.kind !== 'words' && (parameter.optional || parameter.default === null)) select.add(new Option('chosen', ''));
    const option = ({ name, help }) => Object.assign(new Option(name, name), { title: help });
    select.append(...parameter.words.map(option));
    if (parameter.kind === 'words') {
      select.multiple = true;
      select.size = Math.min(6, parameter.words.length);
      for (const choice of select.options) choice.selected = parameter.default?.includes(choice.value) ?? false;
      select.onchange = () => {
        const chosen = [...select.selectedOptions].map((choice) => choice.value);
        this.set(parameter, chosen.length > 0 ? chosen : parameter.default);
      };
    } else {
      select.value = parameter.default ?? '';
      select.onchange = () => this.set(parameter, select.value || null);
    }
    return select;
  }

  number(parameter) {
    const input = document.createElement('input');
    input.type = 'number';
    input.dataset.parameter = parameter.name;
    input.min = parameter.min;
    input.max = parameter.max;
    input.step = parameter.kind === 'count' ? 1 : 'any';
    input.placeholder = parameter.default === null ? 'measured' : parameter.default;
    input.value = parameter.default ?? '';
    // What is no number in the range is told by the form, and again by the library.
    input.onchange = () => this.set(parameter, input.value === '' ? parameter.default : Number(input.value));
    return input;
  }

  /// The request that the library reads, as JSON.
  request() {
    const bake = {};
    if ($('texel').value === '--bits 8') bake.texel = { format: 'png', bits: 8 };
    if ($('texel').value === '--bits 32') bake.texel = { format: 'exr', bits: 32 };
    if ($('layout').value !== 'auto') bake.layout = $('layout').value;
    if ($('ao').checked) bake.occlusion = {};
    if ($('curvature').checked) bake.curvature = 'mean';
    return JSON.stringify({
      method: this.method.name,
      parameters: this.values,
      fix_boundary: $('fix-boundary').checked,
      max_displacement: $('max-displacement').value === '' ? null : Number($('max-displacement').value),
      preserve_volume: $('preserve-volume').checked,
      bake,
    });
  }

  /// Options of `planish bake` that ask for the same.
  options() {
    const options = this.method.name === this.first ? [] : [`--method ${this.method.name}`];
    for (const [name, value] of Object.entries(this.values)) if (value !== null) options.push(`--${name} ${[value].flat().join(',')}`);
    if ($('fix-boundary').checked) options.push('--fix boundary');
    if ($('preserve-volume').checked) options.push('--preserve-volume');
    if ($('max-displacement').value !== '') options.push(`--max-displacement ${$('max-displacement').value}`);
    if ($('texel').value) options.push($('texel').value);
    if ($('layout').value !== 'auto') options.push(`--layout ${$('layout').value}`);
    if ($('ao').checked) options.push('--ao');
    if ($('curvature').checked) options.push('--curvature');
    return options.map((option) => ` ${option}`).join('');
  }
}
