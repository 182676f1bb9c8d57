// Files that a user drops or chooses, with their paths.

/// Files of a drop, folders opened: [{ path, file }]. Has to be called before the event ends.
export async function dropped(transfer) {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
  if (entries.length === 0) return chosen(transfer.files);
  return rooted((await Promise.all(entries.map(within))).flat());
}

/// Files of a file dialog: [{ path, file }].
export function chosen(files) {
  return rooted([...files].map((file) => ({ path: file.webkitRelativePath || file.name, file })));
}

async function within(entry) {
  if (entry.isFile) {
    const file = await new Promise((resolve, reject) => entry.file(resolve, reject));
    return [{ path: entry.fullPath.replace(/^\//, ''), file }];
  }
  const reader = entry.createReader();
  const found = [];
  // It gives a hundred entries at a time.
  for (;;) {
    const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (some.length === 0) return found;
    found.push(...(await Promise.all(some.map(within))).flat());
  }
}

/// Takes off the folders that all paths have in common.
function rooted(files) {
  const folders = files.map(({ path }) => path.split('/').slice(0, -1));
  let depth = 0;
  while (folders.length > 0 && folders.every((folder) => depth < folder.length && folder[depth] === folders[0][depth])) depth++;
  return files.map(({ path, file }) => ({ path: path.split('/').slice(depth).join('/'), file }));
}

/// Hands bytes to the user as a file.
export function save(name, bytes) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob([bytes]));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
