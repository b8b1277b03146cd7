#include "deepslam/batch/worker_pool.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include <fmt/format.h>

namespace deepslam::batch {
namespace {

constexpr std::size_t kMaxLineBytes = std::size_t{1} << 20;  // a worker that sends more is broken

void CloseFd(int& fd) {
  if (fd >= 0) ::close(fd);
  fd = -1;
}

// Only what may be called between fork and exec.
[[noreturn]] void BecomeWorker(const char* program,
                               char* const* arguments,
                               int input,
                               int output,
                               pid_t parent) {
  // A group of its own: Ctrl-C at the terminal reaches the parent alone, which passes it on once.
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (::getppid() != parent) ::_exit(130);  // it died before prctl
  // Where memory runs out, a worker goes before the parent and before everybody else's programs.
  if (const int fd = ::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC); fd >= 0) {
    [[maybe_unused]] const ssize_t written = ::write(fd, "500", 3);
    ::close(fd);
  }
  struct sigaction action {};
  action.sa_handler = SIG_DFL;
  for (const int signal : {SIGINT, SIGTERM, SIGPIPE}) ::sigaction(signal, &action, nullptr);
  if (::dup2(input, STDIN_FILENO) < 0 || ::dup2(output, STDOUT_FILENO) < 0) ::_exit(126);
  ::execv(program, arguments);
  ::_exit(127);
}

}  // namespace

WorkerPool::WorkerPool(std::string program, std::vector<std::string> arguments, int num_workers)
    : program_(std::move(program)),
      arguments_(std::move(arguments)),
      workers_(static_cast<std::size_t>(num_workers)) {
  std::signal(SIGPIPE, SIG_IGN);  // a dead worker is told by Wait
}

WorkerPool::~WorkerPool() {
  for (Worker& worker : workers_) {
    if (worker.process > 0) {
      ::kill(worker.process, SIGKILL);
      while (::waitpid(worker.process, nullptr, 0) < 0 && errno == EINTR) {
      }
    }
    CloseFd(worker.input);
    CloseFd(worker.output);
  }
}

Status WorkerPool::Start(Worker& worker) {
  std::array<int, 2> to_worker{}, from_worker{};
  if (::pipe2(to_worker.data(), O_CLOEXEC) != 0)
    return Failed(fmt::format("no pipe to a worker: {}", std::strerror(errno)));
  if (::pipe2(from_worker.data(), O_CLOEXEC) != 0) {
    const int error = errno;
    ::close(to_worker[0]);
    ::close(to_worker[1]);
    return Failed(fmt::format("no pipe from a worker: {}", std::strerror(error)));
  }
  std::vector<char*> arguments = {program_.data()};
  for (std::string& argument : arguments_) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child == 0)
    BecomeWorker(program_.c_str(), arguments.data(), to_worker[0], from_worker[1], parent);
  const int error = errno;
  ::close(to_worker[0]);
  ::close(from_worker[1]);
  if (child < 0) {
    ::close(to_worker[1]);
    ::close(from_worker[0]);
    return Failed(fmt::format("no process for a worker: {}", std::strerror(error)));
  }
  worker = {child, to_worker[1], from_worker[0], {}};
  return Ok();
}

Status WorkerPool::Send(int index, std::string_view line) {
  Worker& worker = workers_[static_cast<std::size_t>(index)];
  if (worker.process == 0) {
    if (Status status = Start(worker); !status.ok()) return status;
  }
  std::string bytes(line);
  bytes += '\n';
  // Lines are far shorter than a pipe. One that cannot be written belongs to a worker that died:
  // Wait tells.
  [[maybe_unused]] const ssize_t written = ::write(worker.input, bytes.data(), bytes.size());
  return Ok();
}

void WorkerPool::CloseInputs() {
  for (Worker& worker : workers_) CloseFd(worker.input);
}

void WorkerPool::SignalAll(int signal) {
  for (const Worker& worker : workers_) {
    if (worker.process > 0) ::kill(worker.process, signal);
  }
}

void WorkerPool::ReadFrom(int index, std::vector<WorkerEvent>& events) {
  Worker& worker = workers_[static_cast<std::size_t>(index)];
  std::array<char, 65536> buffer{};
  const ssize_t got = ::read(worker.output, buffer.data(), buffer.size());
  if (got < 0) return;  // interrupted: poll comes again
  if (got > 0) {
    worker.unread.append(buffer.data(), static_cast<std::size_t>(got));
    std::size_t end = 0;
    while ((end = worker.unread.find('\n')) != std::string::npos) {
      events.push_back({index, false, worker.unread.substr(0, end), 0, 0});
      worker.unread.erase(0, end + 1);
    }
    if (worker.unread.size() > kMaxLineBytes) ::kill(worker.process, SIGKILL);
    return;
  }
  int status = 0;
  while (::waitpid(worker.process, &status, 0) < 0 && errno == EINTR) {
  }
  WorkerEvent ended;
  ended.worker = index;
  ended.ended = true;
  if (WIFEXITED(status)) ended.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) ended.signal = WTERMSIG(status);
  CloseFd(worker.input);
  CloseFd(worker.output);
  worker = {};
  events.push_back(std::move(ended));
}

std::vector<WorkerEvent> WorkerPool::Wait(std::chrono::milliseconds time) {
  std::vector<pollfd> polled;
  std::vector<int> indices;
  for (std::size_t i = 0; i < workers_.size(); ++i) {
    if (workers_[i].process == 0) continue;
    polled.push_back({workers_[i].output, POLLIN, 0});
    indices.push_back(static_cast<int>(i));
  }
  std::vector<WorkerEvent> events;
  if (::poll(polled.data(), polled.size(), static_cast<int>(time.count())) <= 0) return events;
  for (std::size_t i = 0; i < polled.size(); ++i) {
    if (polled[i].revents != 0) ReadFrom(indices[i], events);
  }
  return events;
}

bool WorkerPool::any_running() const {
  for (const Worker& worker : workers_) {
    if (worker.process > 0) return true;
  }
  return false;
}

pid_t WorkerPool::process(int worker) const {
  return workers_[static_cast<std::size_t>(worker)].process;
}

}  // namespace deepslam::batch
