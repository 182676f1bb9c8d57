//! The command `planish batch`: many meshes, of which each is done whole or named with its error.

mod inputs;
mod journal;

use super::bake::{self, Goal};
use super::denoise::Request;
use crate::args::BatchArgs;
use crate::console::Console;
use crate::failure::Failure;
use inputs::Task;
use journal::{Journal, Line};
use planish_files::terminal;
use planish_files::text::{count, shown};
use planish_geometry::bake::BakeSettings;
use planish_geometry::progress::Progress;
use serde::Serialize;
use serde_json::{Value, json};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Counts of a batch.
#[derive(Clone, Copy, Debug, Default, Serialize)]
struct Summary {
    meshes: usize,
    done: usize,
    failed: usize,
    /// Meshes that were done before.
    skipped: usize,
    seconds: f64,
}

pub(crate) fn run(args: &BatchArgs, console: &Console) -> Result<(), Failure> {
    let start = Instant::now();
    let settings = bake::settings(&args.map, args.welding.weld)?;
    args.method.check()?;
    console.stage("searching");
    let tasks = inputs::tasks(args)?;
    console.check()?;
    let journal = Journal::open(args)?;
    let (skipped, tasks): (Vec<Task>, Vec<Task>) = tasks.into_iter().partition(|task| journal.has(task));
    let mut summary = Summary { meshes: skipped.len() + tasks.len(), skipped: skipped.len(), ..Summary::default() };
    console.stage("working");
    let batch = Batch { args, settings, console, journal, total: tasks.len(), state: Mutex::default() };
    let jobs = args.jobs.map_or_else(terminal::thread_count, |jobs| jobs as usize).clamp(1, tasks.len().max(1));
    batch.work(&tasks, jobs);
    let State { done, failed, broken } = batch.state.into_inner().unwrap_or_else(PoisonError::into_inner);
    if let Some(failure) = broken {
        return Err(failure);
    }
    (summary.done, summary.failed, summary.seconds) = (done, failed, start.elapsed().as_secs_f64());
    report(console, summary)?;
    let left = tasks.len() - done - failed;
    if left > 0 {
        let all = summary.meshes;
        return Err(Failure::Internal(format!(
            "interrupted; {left} of {all} meshes are left, which --resume goes on with"
        )));
    }
    if failed > 0 {
        let all = count(summary.meshes, "mesh", "meshes");
        return Err(Failure::Internal(format!("{failed} of {all} failed")));
    }
    Ok(())
}

/// Prints the summary: as JSON after the lines of the meshes, or as text on standard error.
fn report(console: &Console, summary: Summary) -> Result<(), Failure> {
    if console.is_json() {
        return console.print_bytes(format!("{}\n", json!({ "summary": summary })).as_bytes());
    }
    let Summary { meshes, done, failed, skipped, seconds } = summary;
    let before = if skipped > 0 { format!(", {skipped} done before") } else { String::new() };
    console.aside(&format!(
        "{}: {done} done, {failed} failed{before}, in {seconds:.1} s\n",
        count(meshes, "mesh", "meshes")
    ));
    Ok(())
}

/// Counts of the meshes of a batch that are done, and how they ended.
#[derive(Default)]
struct State {
    done: usize,
    failed: usize,
    /// Reason why the batch cannot go on.
    broken: Option<Failure>,
}

/// A batch that is being worked on.
struct Batch<'a> {
    args: &'a BatchArgs,
    settings: BakeSettings,
    console: &'a Console,
    journal: Journal,
    total: usize,
    state: Mutex<State>,
}

/// Progress of one of several meshes: it is not shown, and Ctrl-C stops it.
struct Unseen<'a> {
    console: &'a Console,
}

impl Progress for Unseen<'_> {
    fn cancelled(&self) -> bool {
        self.console.cancelled()
    }
}

impl Batch<'_> {
    /// Works on tasks in their order, on so many at a time.
    fn work(&self, tasks: &[Task], jobs: usize) {
        let (next, is_broken) = (AtomicUsize::new(0), AtomicBool::new(false));
        let worker = || {
            terminal::with_part_of_threads(jobs, || {
                while !self.console.cancelled() && !is_broken.load(Ordering::Relaxed) {
                    let Some(task) = tasks.get(next.fetch_add(1, Ordering::Relaxed)) else { break };
                    if let Err(failure) = self.one(task) {
                        is_broken.store(true, Ordering::Relaxed);
                        self.state.lock().unwrap_or_else(PoisonError::into_inner).broken.get_or_insert(failure);
                    }
                }
            });
        };
        std::thread::scope(|scope| {
            let spawn = |_: &usize| std::thread::Builder::new().spawn_scoped(scope, worker).is_ok();
            // Where the system gives no threads, this one does it.
            if (0..jobs).filter(spawn).count() == 0 {
                worker();
            }
        });
    }

    /// Works on one mesh and says how it went. Fails only if the batch cannot go on.
    fn one(&self, task: &Task) -> Result<(), Failure> {
        let start = Instant::now();
        let progress = Unseen { console: self.console };
        // A defect of the program that one mesh shows must not cost the others.
        let result = catch_unwind(AssertUnwindSafe(|| self.result(task, &progress)));
        let result =
            result.unwrap_or_else(|_| Err(Failure::Internal(format!("{}: internal error", shown(&task.input)))));
        if matches!(result, Err(Failure::Interrupted)) {
            return Ok(());
        }
        let is_done = result.is_ok();
        let line = self.journal.line(task, start.elapsed(), result);
        // Lines are printed in the order of the journal.
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let text = self.journal.append(&line)?;
        if is_done {
            state.done += 1;
        } else {
            state.failed += 1;
        }
        self.console.done((state.done + state.failed) as f64 / self.total as f64);
        self.console.print_line(&text)
    }

    /// Denoises or bakes a mesh; returns the fields of its report.
    fn result(&self, task: &Task, progress: &dyn Progress) -> Result<Value, Failure> {
        let Self { args, settings, .. } = self;
        if args.bake {
            let goal = Goal { method: &args.method, target: None };
            let (baked, folder) = bake::bake(&task.input, &task.output, settings, &goal, args.trust.rule(), progress)?;
            baked.write(folder)?;
            return Ok(baked_fields(&baked, &task.output));
        }
        let request = Request {
            input: &task.input,
            output: &task.output,
            method: &args.method,
            welding: args.welding.weld,
            update_normals: args.update_normals,
            trust: args.trust.rule(),
        };
        let (report, warnings) = request.run(request.open()?, None, progress)?;
        let mut fields = serde_json::to_value(&report).map_err(Failure::internal)?;
        fields["warnings"] = warnings.into();
        Ok(fields)
    }
}

/// Fields of the report of a bake: what the manifest says about the result.
fn baked_fields(baked: &planish_files::bake_files::Baked, folder: &Path) -> Value {
    let manifest = &baked.bundle.manifest;
    json!({
        "output": folder.display().to_string(),
        "method": manifest.method,
        "choice": manifest.choice,
        "displacement": manifest.displacement,
        "report": manifest.report,
        "warnings": baked.warnings,
    })
}

impl Line {
    /// Makes the line of a mesh: what identifies it, whether it is done, and the report or the error.
    fn with_result(mut self, result: Result<Value, Failure>) -> Self {
        match result {
            Ok(Value::Object(fields)) => self.fields.extend(fields),
            Ok(_) => {}
            Err(failure) => {
                self.ok = false;
                self.fields.insert("error".to_owned(), failure.to_string().into());
                self.fields.insert("exit_code".to_owned(), failure.status().into());
            }
        }
        self
    }
}
