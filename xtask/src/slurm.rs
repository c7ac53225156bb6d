//! The array job of a simulation on a cluster of one node, which is this machine: a worker is killed in the
//! midst of its work, Slurm starts it again, and the set is that of a run without shards, byte for byte.
//!
//! Needs Slurm and root: `apt-get install slurmctld slurmd slurm-client` on Debian. The daemons that packages
//! start are left alone: this cluster has ports, a configuration and a folder of its own.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};

/// Folder of all that is made, which stays there to be looked at.
const FOLDER: &str = "target/slurm";
const JOB: &str = include_str!("../../configs/jobs/simulate.slurm");
/// Lines of the file and those of the short run in their place: two sequences a shard, one after the other.
const SHORTENED: [(&str, &str); 4] = [
    ("--array=1-67", "--array=1-4"),
    ("--cpus-per-task=4", "--cpus-per-task=1"),
    ("SHARDS=67", "SHARDS=4"),
    ("simulate eventhands --out \"$OUT\" --sequences 268 --seconds 600", "SHORT"),
];
const SHORT: &str = "simulate quick --out \"$OUT\" --sequences 8 --seconds 20";
/// The sequences of shard 2 of 4: the worker is killed when it has the first.
const FIRST: &str = "0001.sha256";
const SECOND: &str = "0005.";
/// Slurm itself waits two minutes before it starts a task again.
const LIMIT: Duration = Duration::from_secs(1200);

/// Ends a daemon with the value.
struct Daemon(Child);

impl Drop for Daemon {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Runs the job with the program of `args`, or the release build.
pub(crate) fn run(args: &[String], say: fn(&str)) -> Result<()> {
    let program = args.first().map_or("target/release/evpose", String::as_str);
    let program = fs::canonicalize(program)
        .with_context(|| format!("{program}: build it, or name another program"))?;
    if Path::new(FOLDER).exists() {
        fs::remove_dir_all(FOLDER)?;
    }
    fs::create_dir_all(format!("{FOLDER}/bin"))?;
    let folder = fs::canonicalize(FOLDER)?;
    // The job calls the program by its name.
    fs::copy(&program, folder.join("bin/evpose"))?;
    let _cluster = start(&folder)?;
    say("without shards");
    let whole = SHORT.replace("\"$OUT\"", "whole");
    succeeds(command(&folder, "evpose").args(whole.split(' ')).args(["--threads", "1"]))?;
    let mut job = JOB.to_owned();
    for (from, to) in SHORTENED {
        ensure!(job.contains(from), "configs/jobs/simulate.slurm has no `{from}`");
        job = job.replace(from, if to == "SHORT" { SHORT } else { to });
    }
    fs::write(folder.join("job.slurm"), job)?;
    say("an array job of four shards");
    succeeds(command(&folder, "sbatch").env("EVPOSE_OUT", folder.join("shards")).arg("job.slurm"))?;
    kill_worker(&folder, say)?;
    wait(|| Ok(output(command(&folder, "squeue").arg("--noheader"))?.trim().is_empty()))?;
    succeeds(Command::new("diff").arg("-r").args(["whole", "shards"].map(|set| folder.join(set))))?;
    let log = fs::read_to_string(folder.join("evpose-simulate-1_2.log"))?;
    ensure!(log.contains("kept 1 complete sequence"), "the worker did not go on:\n{log}");
    say(
        "the files of both are the same, and the worker that was killed kept what it had completed",
    );
    Ok(())
}

/// Starts both daemons.
fn start(folder: &Path) -> Result<[Daemon; 2]> {
    let here = folder.display();
    let host =
        fs::read_to_string("/proc/sys/kernel/hostname").context("the name of this machine")?;
    let host = host.trim();
    // A worker that a signal ended is started again, as one is whose node failed. Four tasks run at a time
    // whatever this machine has.
    let config = format!(
        "ClusterName=one\nSlurmctldHost={host}(127.0.0.1)\nSlurmUser=root\nSlurmdUser=root\n\
         AuthType=auth/none\nCredType=cred/none\nStateSaveLocation={here}/state\n\
         SlurmdSpoolDir={here}/spool\nSlurmctldPidFile={here}/slurmctld.pid\n\
         SlurmdPidFile={here}/slurmd.pid\nSlurmctldPort=17817\nSlurmdPort=17818\n\
         ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSelectType=select/cons_tres\n\
         SelectTypeParameters=CR_Core\nReturnToService=2\nRequeueExit=137\n\
         SlurmdParameters=config_overrides\nAccountingStorageType=accounting_storage/none\n\
         JobAcctGatherType=jobacct_gather/none\n\
         NodeName=one NodeHostname={host} NodeAddr=127.0.0.1 CPUs=4 RealMemory=8000\n\
         PartitionName=all Nodes=one Default=YES MaxTime=INFINITE State=UP\n"
    );
    fs::write(folder.join("slurm.conf"), config)?;
    fs::create_dir_all(folder.join("state"))?;
    fs::create_dir_all(folder.join("spool"))?;
    let daemon = |name: &str, args: &[&str]| {
        let log = fs::File::create(folder.join(format!("{name}.log")))?;
        let mut command = command(folder, name);
        command.arg("-D").args(args).stdout(log.try_clone()?).stderr(log);
        let child = command.spawn().with_context(|| {
            format!("{name}: Slurm is not here; `apt-get install slurmctld slurmd slurm-client`")
        })?;
        Ok::<_, anyhow::Error>(Daemon(child))
    };
    let daemons = [daemon("slurmctld", &["-c", "-i"])?, daemon("slurmd", &["-N", "one"])?];
    let is_idle =
        || Ok(output(command(folder, "sinfo").args(["-h", "-o", "%t"]))?.trim() == "idle");
    wait(is_idle).with_context(|| format!("the node does not answer: {here}/slurmctld.log"))?;
    Ok(daemons)
}

/// Kills the worker of shard 2 when it has completed one sequence and begun another.
fn kill_worker(folder: &Path, say: fn(&str)) -> Result<()> {
    let shards = folder.join("shards");
    let has_begun = || {
        let Ok(files) = fs::read_dir(&shards) else { return Ok(false) };
        let names = files.map(|file| Ok(file?.file_name().to_string_lossy().into_owned()));
        let names = names.collect::<Result<Vec<_>>>()?;
        let has_first = names.iter().any(|name| name == FIRST);
        Ok(has_first && names.iter().any(|name| name.starts_with(SECOND) && name.ends_with(".tmp")))
    };
    wait(has_begun)?;
    let program = folder.join("bin/evpose").display().to_string();
    let is_worker = |process: &PathBuf| {
        // Words are separated by zeros. `srun`, which has the same ones, begins otherwise.
        let words = fs::read(process.join("cmdline")).unwrap_or_default();
        let words = String::from_utf8_lossy(&words).replace('\0', " ");
        words.starts_with(&program) && words.contains("--shard 2/4")
    };
    let mut processes = fs::read_dir("/proc")?.filter_map(|entry| Some(entry.ok()?.path()));
    let Some(worker) = processes.find(is_worker) else { bail!("no worker has shard 2") };
    let id = worker.file_name().unwrap_or_default();
    say("a worker is killed; Slurm waits two minutes before it starts it again");
    succeeds(Command::new("kill").arg("-9").arg(id))
}

/// A program that finds the cluster, and the program to be run.
fn command(folder: &Path, name: &str) -> Command {
    let path = std::env::var("PATH").unwrap_or_default();
    let program = folder.join("bin/evpose");
    let mut command =
        Command::new(if name == "evpose" { program.as_os_str() } else { name.as_ref() });
    command.current_dir(folder).env("SLURM_CONF", folder.join("slurm.conf"));
    command.env("PATH", format!("{}:{path}:/usr/sbin", folder.join("bin").display()));
    command.stdin(Stdio::null());
    command
}

fn succeeds(command: &mut Command) -> Result<()> {
    let status = command.status().with_context(|| format!("starting {command:?}"))?;
    ensure!(status.success(), "{command:?} ended with {status}");
    Ok(())
}

fn output(command: &mut Command) -> Result<String> {
    let output = command.stderr(Stdio::null()).output();
    let output = output.with_context(|| format!("starting {command:?}"))?;
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Asks every so often until something is so.
fn wait(is_so: impl Fn() -> Result<bool>) -> Result<()> {
    let begin = Instant::now();
    while !is_so()? {
        ensure!(begin.elapsed() < LIMIT, "nothing happened within {} s", LIMIT.as_secs());
        sleep(Duration::from_millis(200));
    }
    Ok(())
}
