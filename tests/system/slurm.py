"""A Slurm cluster of one node: munged, slurmctld and slurmd as plain processes with their own files, in this process's network
namespace. They are ended by their process ids."""
import os
import pathlib
import shutil
import socket
import subprocess

from case import PATIENCE_S, PROGRAM_PATIENCE_S, wait_for

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch")
CONFIG = """\
ClusterName=ovws
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CredType=cred/munge
SlurmctldPort=17001
SlurmdPort=17002
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_min_interval=1000,batch_sched_delay=0
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def missing():
    """The programs that are not installed."""
    return [name for name in PROGRAMS if shutil.which(name, path="/usr/bin:/usr/sbin") is None]


class Slurm:
    """Use it in a network namespace of its own, as root."""

    def __init__(self, folder):
        self.folder, self.processes = pathlib.Path(folder), []
        self.env = dict(os.environ, SLURM_CONF=str(self.folder / "slurm.conf"))
        host = socket.gethostname()
        for name in ("munge", "state", "spool"):
            (self.folder / name).mkdir(mode=0o711, parents=True)
        key = self.folder / "munge" / "key"
        key.touch(mode=0o600)
        key.write_bytes(os.urandom(1024))
        (self.folder / "slurm.conf").write_text(CONFIG.format(host=host, folder=self.folder))
        # Slurm binds to the addresses of "any" host, which glibc gives only if there is an address beside the loopback's.
        subprocess.run(["ip", "address", "add", "192.0.2.1/32", "dev", "lo"], check=True)
        files = (f"--{name}-file={self.folder}/munge/{name}" for name in ("key", "pid", "log", "seed"))
        self.start("munged", "--foreground", "--force", *files, f"--socket={self.folder}/munge/socket")
        wait_for((self.folder / "munge" / "socket").exists, what="munged's socket")
        self.start("slurmctld", "-D", "-i")
        self.start("slurmd", "-D", "-N", host)
        wait_for(lambda: "idle" in self.run("sinfo", "--noheader", "--format=%T"), what="an idle node")

    def start(self, name, *arguments):
        with open(self.folder / f"{name}.log", "wb") as log:
            program = shutil.which(name, path="/usr/bin:/usr/sbin")
            self.processes.append(subprocess.Popen([program, *arguments], env=self.env, stdin=subprocess.DEVNULL, stdout=log, stderr=log))

    def run(self, *command):
        return subprocess.run(command, env=self.env, capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S).stdout

    def close(self):
        self.run("scancel", "--quiet", "--state=PENDING,RUNNING", "--partition=all")
        for process in reversed(self.processes):  # munged last
            process.terminate()
            try:
                process.wait(PATIENCE_S)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
