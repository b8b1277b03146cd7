// Worker processes that are sent lines and answer with lines. A worker that dies takes nothing with
// it: the pool says how it ended, and starts another one when there is more to send.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"

namespace deepslam::batch {

struct WorkerEvent {
  int worker = 0;
  bool ended = false;  // the process is gone; else it sent `line`
  std::string line;    // without its end
  int exit_code = 0;   // of an ended worker, where no signal killed it
  int signal = 0;      // that killed it; 0: none
};

class WorkerPool {
 public:
  // `program` is started with `arguments` where a worker is sent something and does not run. The
  // children are told to stop (SIGTERM) when this process ends, however it ends.
  WorkerPool(std::string program, std::vector<std::string> arguments, int num_workers);
  // Kills what still runs.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  // kFailed when no process can be started.
  [[nodiscard]] Status Send(int worker, std::string_view line);
  // No more lines will come: a worker ends after the one it works on.
  void CloseInputs();
  void SignalAll(int signal);
  // What happened, at once when something did, else after the time or a signal to this process.
  [[nodiscard]] std::vector<WorkerEvent> Wait(std::chrono::milliseconds time);
  [[nodiscard]] bool any_running() const;
  [[nodiscard]] pid_t process(int worker) const;

 private:
  struct Worker {
    pid_t process = 0;  // 0: none
    int input = -1;     // we write
    int output = -1;    // we read
    std::string unread;
  };
  Status Start(Worker& worker);
  void ReadFrom(int index, std::vector<WorkerEvent>& events);

  std::string program_;
  std::vector<std::string> arguments_;
  std::vector<Worker> workers_;
};

}  // namespace deepslam::batch
