// The folder of one run: who owns it now, which version made it, what dead runs left behind.
//
//   workspace.json        format and version of the layout
//   .lock                 held while a run is alive; holds its process id
//   <stage>/              a finished stage
//   <stage>.partial-<pid> a stage being written; removed when the next run starts
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "deepslam/core/result.h"

namespace deepslam::pipeline {

inline constexpr int kWorkspaceVersion = 1;  // raised when folders or names of files change

// Refuses a folder that another version made or that is no workspace but holds files, naming the
// remedy. A folder that does not exist is fine when `may_be_missing`.
[[nodiscard]] Status CheckWorkspace(const std::filesystem::path& folder, bool may_be_missing);

// A workspace held by this process until the object dies.
class Workspace {
 public:
  // Makes the folder where needed, takes the lock (kFailed with the holder's process id when
  // another run still has it after that time) and removes what dead runs of the stages left
  // half-done.
  [[nodiscard]] static Result<Workspace> Open(const std::filesystem::path& folder,
                                              std::span<const std::string> stage_names,
                                              int lock_patience_s = 0);
  ~Workspace();
  Workspace(Workspace&&) noexcept;
  Workspace& operator=(Workspace&&) noexcept;

  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

 private:
  Workspace(std::filesystem::path folder, int lock_fd);
  std::filesystem::path folder_;
  int lock_fd_ = -1;
};

}  // namespace deepslam::pipeline
