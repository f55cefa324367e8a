"""A Slurm of its own on this machine: munged, slurmctld and slurmd in a folder, on ports of loopback, without accounting."""

import os
import shutil
import socket
import subprocess
import time

NEEDED = ("munged", "mungekey", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "scontrol")

_CONF = """
ClusterName=here
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CryptoType=crypto/munge
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/builtin
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ReturnToService=2
SlurmdParameters=config_overrides
KillWait=1
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=500 State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def why_not():
    """Why there can be none here; None if there can."""
    missing = [name for name in NEEDED if not which(name)]
    if missing:
        return f"Slurm is not installed (apt-get install slurm-wlm munge): no {missing[0]}"
    if os.geteuid() != 0:
        return "the daemons of Slurm need root"
    return None


def which(name):
    return shutil.which(name, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin")


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for s in sockets:
        s.bind(("127.0.0.1", 0))
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


class Slurm:
    """Starts it; `environment` is what its clients need. Raises RuntimeError with what a daemon has said."""

    def __init__(self, folder):
        self.folder = folder
        self._daemons = []
        host = socket.gethostname().split(".")[0]
        for name in ("state", "spool"):
            (folder / name).mkdir()
        (folder / "slurm.conf").write_text(_CONF.format(host=host, folder=folder, ports=free_ports(2)))
        self.environment = {"SLURM_CONF": str(folder / "slurm.conf")}
        folder.chmod(0o755)  # munged refuses what others could write to
        subprocess.run([which("mungekey"), "--create", "--keyfile", folder / "munge.key"], check=True)
        self._start("munged", "--foreground", "--force", f"--key-file={folder}/munge.key", f"--socket={folder}/munge.socket",
                    f"--pid-file={folder}/munged.pid", f"--log-file={folder}/munged.log", f"--seed-file={folder}/munge.seed")
        self._wait(lambda: (folder / "munge.socket").exists(), "munged")
        self._start("slurmctld", "-D", "-i")
        self._start("slurmd", "-D", "-N", host)
        self._wait(lambda: "idle" in self.ask("sinfo", "-h", "-o", "%T"), "slurmctld")

    def ask(self, *words):
        done = subprocess.run(words, env=os.environ | self.environment, capture_output=True, text=True, check=False)
        return done.stdout + done.stderr

    def stop(self):
        for daemon in reversed(self._daemons):
            daemon.terminate()
        for daemon in self._daemons:
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()

    def _start(self, name, *words):
        with (self.folder / f"{name}.out").open("w") as out:
            self._daemons.append(subprocess.Popen([which(name), *words], env=os.environ | self.environment, stdout=out,
                                                  stderr=subprocess.STDOUT))

    def _wait(self, is_there, name):
        until = time.monotonic() + 15
        while not is_there():
            if time.monotonic() > until or any(daemon.poll() is not None for daemon in self._daemons):
                said = "".join(file.read_text()[-600:] for file in sorted(self.folder.glob("*.[lo]*")) if file.is_file())
                self.stop()
                raise RuntimeError(f"{name} does not answer: {said}")
            time.sleep(0.1)
