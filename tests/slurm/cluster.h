// A Slurm of our own on loopback: one node with two processors, its own key, no accounting.
#pragma once

#include <arpa/inet.h>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <functional>
#include <netinet/in.h>
#include <string>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

#include "base/error.h"
#include "base/files.h"
#include "tests/support/shell.h"
#include "tests/support/temp_folder.h"

namespace equilux::test {

/// True as soon as `condition` is; false after `seconds`.
inline bool wait_for(double seconds, const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

class Cluster {
 public:
  Cluster() {
    const std::string root = folder_.path().string();
    for (const char* part : {"state", "spool"}) make_folder(folder_.path() / part);
    save_text(folder_.path() / "slurm.conf", make_config());
    ::setenv("SLURM_CONF", (root + "/slurm.conf").c_str(), 1);
    begin(
        fmt::format("umask 077; head -c 1024 /dev/urandom >{0}/munge.key; chmod 755 {0}; "
                    "munged --force --socket={0}/munge.socket --key-file={0}/munge.key "
                    "--log-file={0}/munged.log --pid-file={0}/munged.pid --seed-file={0}/munged.seed",
                    root));
    begin("slurmctld -i -f \"$SLURM_CONF\"");
    begin("slurmd -f \"$SLURM_CONF\"");
    is_up_ = wait_for(30, [] { return run_shell("sinfo -h -o %t").text == "idle\n"; });
  }
  ~Cluster() {
    run_shell("scancel --state=PENDING; scancel --state=RUNNING");
    wait_for(10, [this] { return is_idle(); });
    for (const char* daemon : {"slurmd", "slurmctld", "munged"}) stop(daemon);
    ::unsetenv("SLURM_CONF");
  }
  Cluster(const Cluster&) = delete;
  Cluster& operator=(const Cluster&) = delete;

  bool is_up() const { return is_up_; }
  const std::string& said() const { return said_; }

  /// Nothing is waiting or running.
  static bool is_idle() { return run_shell("squeue -h").text.empty(); }

 private:
  void begin(const std::string& command) { said_ += run_shell(command + " </dev/null").text; }

  void stop(const std::string& daemon) {
    const CommandResult pid = run_shell("cat " + (folder_.path() / (daemon + ".pid")).string());
    const int number = std::atoi(pid.text.c_str());
    if (pid.exit_code != 0 || number <= 1) return;
    ::kill(number, SIGTERM);
    if (!wait_for(10, [number] { return ::kill(number, 0) != 0; })) ::kill(number, SIGKILL);
  }

  static int find_free_port() {
    const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* generic = reinterpret_cast<sockaddr*>(&address);
    EQ_CHECK(::bind(socket, generic, size) == 0 && ::getsockname(socket, generic, &size) == 0);
    ::close(socket);
    return ntohs(address.sin_port);
  }

  std::string make_config() const {
    std::string host = run_shell("hostname -s").text, user = run_shell("id -un").text;
    host.pop_back();
    user.pop_back();
    return fmt::format(
        "ClusterName=equilux\nSlurmctldHost={0}(127.0.0.1)\nSlurmUser={1}\nSlurmdUser={1}\n"
        "AuthType=auth/munge\nAuthInfo=socket={2}/munge.socket\nCredType=cred/munge\n"
        "SlurmctldPort={3}\nSlurmdPort={4}\nStateSaveLocation={2}/state\nSlurmdSpoolDir={2}/spool\n"
        "SlurmctldPidFile={2}/slurmctld.pid\nSlurmdPidFile={2}/slurmd.pid\n"
        "SlurmctldLogFile={2}/slurmctld.log\nSlurmdLogFile={2}/slurmd.log\n"
        "ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSwitchType=switch/none\nMpiDefault=none\n"
        "AccountingStorageType=accounting_storage/none\nJobAcctGatherType=jobacct_gather/none\n"
        "JobCompType=jobcomp/none\nSelectType=select/cons_tres\nSelectTypeParameters=CR_Core\n"
        "ReturnToService=2\nKillWait=2\nSchedulerParameters=sched_interval=1,batch_sched_delay=0\n"
        "NodeName={0} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN\n"
        "PartitionName=main Nodes={0} Default=YES MaxTime=INFINITE State=UP\n",
        host, user, folder_.path().string(), find_free_port(), find_free_port());
  }

  const TempFolder folder_;
  bool is_up_ = false;
  std::string said_;
};

}  // namespace equilux::test
