#include "deepslam/pipeline/workspace.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/artifact/json_reader.h"
#include "deepslam/storage/store.h"

namespace deepslam::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFormat = "deepslam/workspace";
constexpr std::string_view kWorkspaceFile = "workspace.json";
constexpr std::string_view kLockFile = ".lock";

bool IsLeftover(const std::string& name, std::span<const std::string> stage_names) {
  return std::any_of(stage_names.begin(), stage_names.end(), [&](const std::string& stage) {
    return name.starts_with(stage + ".partial-") || name.starts_with(stage + ".old-");
  });
}

Status RemoveLeftovers(const fs::path& folder, std::span<const std::string> stage_names) {
  std::error_code error;
  std::vector<fs::path> leftovers;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (IsLeftover(it->path().filename().string(), stage_names)) leftovers.push_back(it->path());
  }
  for (const fs::path& leftover : leftovers) {
    fs::remove_all(leftover, error);
    if (error)
      return Failed(fmt::format("{}: cannot remove: {}", leftover.string(), error.message()));
  }
  for (const std::string& stage : stage_names) {
    if (Status status = storage::RemoveAsideFiles(folder / stage); !status.ok()) return status;
  }
  return storage::RemoveAsideFiles(folder);
}

Status WriteWorkspaceFile(const fs::path& folder) {
  if (fs::exists(folder / kWorkspaceFile)) return Ok();
  const Result<std::string> text =
      DumpJson(artifact::NewDocument(kFormat, kWorkspaceVersion), kWorkspaceFile);
  if (!text.ok()) return text.error();
  return storage::WriteFileAtomically(folder / kWorkspaceFile, *text);
}

// False when another process still has it after that time.
bool Lock(int fd, int patience_s) {
  for (int waited_s = 0;; ++waited_s) {
    if (::flock(fd, LOCK_EX | LOCK_NB) == 0) return true;
    if (errno != EWOULDBLOCK || waited_s >= patience_s) return false;
    ::sleep(1);
  }
}

Result<int> TakeLock(const fs::path& folder, int patience_s) {
  const fs::path file = folder / kLockFile;
  const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) {
    return Failed(fmt::format("{}: cannot write: {}; choose a workspace you may write to",
                              file.string(),
                              std::strerror(errno)));
  }
  if (!Lock(fd, patience_s)) {
    char holder[32] = {};
    const ssize_t got = ::pread(fd, holder, sizeof(holder) - 1, 0);
    ::close(fd);
    const std::string pid =
        got > 0 ? std::string(holder, static_cast<std::size_t>(got)) : "unknown";
    return Failed(fmt::format(
        "{}: another run (process {}) works in this workspace; wait for it, or choose another one",
        folder.string(),
        pid));
  }
  const std::string pid = std::to_string(::getpid());
  if (::ftruncate(fd, 0) != 0 || ::pwrite(fd, pid.data(), pid.size(), 0) < 0) {
    const int error = errno;
    ::close(fd);
    return Failed(fmt::format("{}: cannot write: {}", file.string(), std::strerror(error)));
  }
  return fd;
}

}  // namespace

Status CheckWorkspace(const fs::path& folder, bool may_be_missing) {
  std::error_code error;
  if (!fs::exists(folder, error)) {
    if (may_be_missing) return Ok();
    return InvalidInput(fmt::format(
        "{}: no such folder; `deepslam run CAPTURE -o WORKSPACE` makes one", folder.string()));
  }
  if (!fs::is_directory(folder, error))
    return InvalidInput(fmt::format("{}: is not a folder; name an empty or new one", folder.string()));
  const fs::path file = folder / kWorkspaceFile;
  if (!fs::exists(file, error)) {
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
      if (it->path().filename() == kLockFile ||
          it->path().filename().string().starts_with(kWorkspaceFile))
        continue;
      return InvalidInput(fmt::format(
          "{}: holds files but is no workspace of deepslam; choose an empty or new folder",
          folder.string()));
    }
    if (may_be_missing) return Ok();
    return InvalidInput(fmt::format("{}: is no workspace of deepslam", folder.string()));
  }
  const Result<std::string> text = storage::ReadFile(file);
  if (!text.ok()) return text.error();
  artifact::JsonReader reader(*text, file.string(), kFormat, kWorkspaceVersion);
  if (!reader.ok()) {
    return InvalidInput(
        fmt::format("{}; or choose another workspace folder", reader.error().message));
  }
  return Ok();
}

Workspace::Workspace(fs::path folder, int lock_fd)
    : folder_(std::move(folder)), lock_fd_(lock_fd) {}

Workspace::Workspace(Workspace&& other) noexcept
    : folder_(std::move(other.folder_)), lock_fd_(std::exchange(other.lock_fd_, -1)) {}

Workspace& Workspace::operator=(Workspace&& other) noexcept {
  std::swap(folder_, other.folder_);
  std::swap(lock_fd_, other.lock_fd_);
  return *this;
}

Workspace::~Workspace() {
  // The file stays: removing it would let a third run lock a new file while a second still waits on
  // the old one.
  if (lock_fd_ >= 0) ::close(lock_fd_);
}

Result<Workspace> Workspace::Open(const fs::path& folder,
                                  std::span<const std::string> stage_names,
                                  int lock_patience_s) {
  if (Status status = CheckWorkspace(folder, true); !status.ok()) return status.error();
  if (Status status = storage::MakeFolders(folder); !status.ok()) return status.error();
  const Result<int> lock = TakeLock(folder, lock_patience_s);
  if (!lock.ok()) return lock.error();
  Workspace workspace(folder, *lock);
  if (Status status = WriteWorkspaceFile(folder); !status.ok()) return status.error();
  if (Status status = RemoveLeftovers(folder, stage_names); !status.ok()) return status.error();
  return workspace;
}

}  // namespace deepslam::pipeline
