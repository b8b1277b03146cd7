"""A Slurm of two nodes on this machine, of its own: keys, sockets, ports and folders are the test's."""
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import time

PROGRAMS = ("sbatch", "squeue", "scancel", "scontrol", "sinfo", "slurmctld", "slurmd", "munged")
NODES = ("n1", "n2")
CONF = """ClusterName=deepslamtest
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
SlurmctldPort={controller_port}
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldPidFile={folder}/slurmctld.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd-%n.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
JobCompType=jobcomp/none
MpiDefault=none
SwitchType=switch/none
SlurmdParameters=config_overrides
ReturnToService=2
SlurmdTimeout=10
SlurmctldTimeout=60
MessageTimeout=5
KillWait=10
MinJobAge=3600
SchedulerParameters=sched_interval=5,batch_sched_delay=1
{nodes}
PartitionName=test Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
"""


def missing():
    """Programs that are not installed."""
    return [name for name in PROGRAMS if not find(name)]


def find(name):
    return shutil.which(name, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin")


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


def children(parents):
    """All processes below those, by /proc."""
    parent_of = {}
    for entry in pathlib.Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parent_of[int(entry.name)] = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            except (OSError, IndexError):
                pass
    found, fresh = set(), set(parents)
    while fresh:
        fresh = {child for child, parent in parent_of.items() if parent in fresh} - found
        found |= fresh
    return found


def parent(pid):
    try:
        return int(pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1])
    except (OSError, IndexError):
        return 0


def command(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/comm").read_text().strip()
    except OSError:
        return ""


def on_node(name):
    """Processes that Slurm started on a node: they know its name."""
    found = set()
    for entry in pathlib.Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                if f"SLURMD_NODENAME={name}".encode() in (entry / "environ").read_bytes().split(b"\0"):
                    found.add(int(entry.name))
            except OSError:
                pass
    return found


class Cluster:
    def __init__(self, folder):
        self.folder = folder
        self.processes = []
        self.nodes = {}
        for name in ("state", "munge", "key"):
            (folder / name).mkdir(parents=True)
        # munged wants its socket where all may look and its key where nobody may.
        (folder / "munge").chmod(0o755)
        (folder / "key").chmod(0o700)
        key = folder / "key" / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        controller_port, *ports = free_ports(1 + len(NODES))
        lines = [f"NodeName={name} NodeAddr=127.0.0.1 NodeHostname={socket.gethostname()} Port={port} CPUs=1 RealMemory=1000 "
                 "State=UNKNOWN" for name, port in zip(NODES, ports)]
        import pwd
        (folder / "slurm.conf").write_text(CONF.format(
            host=socket.gethostname(), user=pwd.getpwuid(os.getuid()).pw_name, folder=folder,
            controller_port=controller_port, nodes="\n".join(lines)))
        self.environment = dict(os.environ, SLURM_CONF=str(folder / "slurm.conf"))

    def run(self, *arguments):
        return subprocess.run([find(arguments[0]), *arguments[1:]], capture_output=True, text=True, env=self.environment,
                              timeout=60)

    def spawn(self, *arguments):
        with open(self.folder / (arguments[0] + ".out"), "ab") as log:
            process = subprocess.Popen([find(arguments[0]), *map(str, arguments[1:])], stdout=log, stderr=log,
                                       env=self.environment, start_new_session=True)
        self.processes.append(process)
        return process

    def start(self, patience_s=60):
        """True once both nodes take jobs; else what was found."""
        munge = self.folder / "munge"
        self.spawn("munged", "-F", "--force", f"--key-file={self.folder}/key/munge.key", f"--socket={munge}/socket",
                   f"--pid-file={munge}/pid", f"--seed-file={munge}/seed", f"--log-file={munge}/log")
        self.wait(lambda: (munge / "socket").exists(), patience_s)
        self.spawn("slurmctld", "-D", "-i")
        for name in NODES:
            self.nodes[name] = self.spawn("slurmd", "-D", "-N", name)
        if self.wait(lambda: self.states() == {name: "idle" for name in NODES}, patience_s):
            return True
        logs = "\n".join(f"{file.name}: {file.read_text(errors='replace')[-1500:]}"
                         for file in [*self.folder.glob("*.log"), *self.folder.glob("*.out")])
        return f"nodes are {self.states()}\n{logs}"

    @staticmethod
    def wait(condition, patience_s):
        end = time.monotonic() + patience_s
        while time.monotonic() < end:
            if condition():
                return True
            time.sleep(0.1)
        return False

    def states(self):
        lines = self.run("sinfo", "--noheader", "--Node", "--format=%N %t").stdout.split()
        return dict(zip(lines[::2], lines[1::2]))

    def lose(self, name):
        """The node is gone, with all that ran on it: nobody is told."""
        daemon = self.nodes.pop(name)
        steps = on_node(name) - {daemon.pid}
        # The keepers of the steps go before the steps: they would tell the controller how these ended.
        keepers = {pid for pid in map(parent, steps) if command(pid) == "slurmstepd"}
        for pid in [daemon.pid, *keepers, *(steps - keepers)]:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        daemon.wait()
        return steps

    def stop(self):
        for process in reversed(self.processes):
            below = children([process.pid])
            for pid in [process.pid, *below]:
                try:
                    os.kill(pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass
            process.wait()
        for name in NODES:
            for pid in on_node(name):
                if pid != os.getpid():
                    try:
                        os.kill(pid, signal.SIGKILL)
                    except ProcessLookupError:
                        pass
