// Progress of long work, and the polite way to stop it. Algorithms report and ask; they never
// print.
#pragma once

#include <cstddef>
#include <string_view>

namespace deepslam {

class Progress {
 public:
  virtual ~Progress() = default;
  // `done` of `total` steps of the current stage; may be called from one thread at a time.
  virtual void Report(std::size_t done, std::size_t total) = 0;
  // A line worth telling the user at warning level ("frame 17 unreadable, skipped").
  virtual void Warn(std::string_view message) = 0;
  // True once the user asked to stop; the callee then returns Interrupted().
  [[nodiscard]] virtual bool StopRequested() const = 0;
};

class SilentProgress final : public Progress {
 public:
  void Report(std::size_t, std::size_t) override {}
  void Warn(std::string_view) override {}
  [[nodiscard]] bool StopRequested() const override { return false; }
};

}  // namespace deepslam
