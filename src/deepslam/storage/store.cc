#include "deepslam/storage/store.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/core/sha256.h"
#include "deepslam/storage/file_descriptor.h"

namespace deepslam::storage {
namespace {

namespace fs = std::filesystem;

Error WriteError(const fs::path& file, std::string_view what, int error) {
  return Failed(fmt::format(
      "{}: cannot {}: {}{}", file.string(), what, std::strerror(error), RemedyOf(error)));
}

enum class Sync { kNow, kLater };

Status WriteBytes(const FileDescriptor& fd, std::string_view bytes, const fs::path& told) {
  while (!bytes.empty()) {
    const ssize_t written =
        ::write(fd.get(), bytes.data(), std::min<std::size_t>(bytes.size(), 1U << 24));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return WriteError(told, "write", errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return Ok();
}

// Messages name `told`, which people know of, where `file` is only on its way to it.
Status WriteAll(const fs::path& file, const TextWriter& text, Sync sync, const fs::path& told) {
  FileDescriptor fd(::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (fd.get() < 0) return WriteError(told, "create", errno);
  if (Status status = text([&](std::string_view piece) { return WriteBytes(fd, piece, told); });
      !status.ok())
    return status;
  if (sync == Sync::kNow && ::fsync(fd.get()) != 0) return WriteError(told, "write to disk", errno);
  if (fd.Close() != 0) return WriteError(told, "close", errno);
  return Ok();
}

Status WriteAll(const fs::path& file, std::string_view bytes, Sync sync, const fs::path& told) {
  return WriteAll(
      file, [bytes](const TextSink& sink) { return sink(bytes); }, sync, told);
}

// How many bytes came, 0 at the end.
Result<std::size_t> ReadSome(const FileDescriptor& fd,
                             char* into,
                             std::size_t most,
                             const fs::path& file) {
  while (true) {
    const ssize_t got = ::read(fd.get(), into, most);
    if (got >= 0) return static_cast<std::size_t>(got);
    if (errno != EINTR)
      return InvalidInput(fmt::format("{}: cannot read: {}", file.string(), std::strerror(errno)));
  }
}

// A file put in its place would take away what others read from or write to.
bool IsDeviceOrPipe(const fs::path& file) {
  struct stat status {};
  return ::stat(file.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

fs::path BehindLinks(fs::path file) {
  constexpr int kMostLinks = 40;  // as Linux follows (path_resolution(7)); ends loops
  std::error_code error;
  for (int n = 0; n < kMostLinks && fs::is_symlink(file, error); ++n) {
    const fs::path target = fs::read_symlink(file, error);
    if (error) break;
    file = file.parent_path() / target;
  }
  return file;
}

// NAME.json.tmp-<pid> or NAME.html.tmp-<pid>, of a process that is no more.
bool IsLeftAside(const std::string& name) {
  constexpr std::string_view kAside = ".tmp-";
  const std::size_t at = name.rfind(kAside);
  if (at == std::string::npos) return false;
  const std::string_view stem = std::string_view(name).substr(0, at);
  if (!stem.ends_with(".json") && !stem.ends_with(".html")) return false;
  pid_t pid = 0;
  const char* const end = name.data() + name.size();
  const auto [digits_end, code] = std::from_chars(name.data() + at + kAside.size(), end, pid);
  if (code != std::errc() || digits_end != end || pid <= 0) return false;
  return ::kill(pid, 0) != 0 && errno == ESRCH;
}

}  // namespace

Result<std::string> ReadFile(const fs::path& file) {
  const Result<FileToRead> opened = OpenToRead(file);
  if (!opened.ok()) return opened.error();
  std::string bytes(opened->num_bytes, '\0');
  std::size_t done = 0;
  while (done < bytes.size()) {
    const Result<std::size_t> got =
        ReadSome(opened->fd, bytes.data() + done, bytes.size() - done, file);
    if (!got.ok()) return got.error();
    if (*got == 0) break;
    done += *got;
  }
  bytes.resize(done);
  return bytes;
}

Result<TextSource> OpenText(const fs::path& file) {
  constexpr std::size_t kPieceBytes = std::size_t{1} << 18;  // a read: few calls, little memory
  Result<FileToRead> opened = OpenToRead(file);
  if (!opened.ok()) return opened.error();
  const auto fd = std::make_shared<FileDescriptor>(std::move(opened->fd));
  const auto piece = std::make_shared<std::string>(kPieceBytes, '\0');
  return TextSource([fd, piece, file]() -> Result<std::string_view> {
    const Result<std::size_t> got = ReadSome(*fd, piece->data(), piece->size(), file);
    if (!got.ok()) return got.error();
    return std::string_view(*piece).substr(0, *got);
  });
}

Status WriteFileAtomically(const fs::path& file, std::string_view bytes) {
  if (IsDeviceOrPipe(file)) return WriteAll(file, bytes, Sync::kLater, file);
  const fs::path target = BehindLinks(file);
  const fs::path aside = fmt::format("{}.tmp-{}", target.string(), ::getpid());
  if (Status status = WriteAll(aside, bytes, Sync::kNow, file); !status.ok()) {
    ::unlink(aside.c_str());
    return status;
  }
  if (::rename(aside.c_str(), target.c_str()) != 0) {
    const int error = errno;
    ::unlink(aside.c_str());
    return WriteError(file, "rename into place", error);
  }
  return SyncFolder(target.has_parent_path() ? target.parent_path() : fs::path("."));
}

Status WriteFileSynced(const fs::path& file, std::string_view bytes) {
  return WriteAll(file, bytes, Sync::kNow, file);
}

Status WriteFileUnsynced(const fs::path& file, std::string_view bytes) {
  return WriteAll(file, bytes, Sync::kLater, file);
}

Status WriteFileUnsynced(const fs::path& file, const TextWriter& text) {
  return WriteAll(file, text, Sync::kLater, file);
}

Status SyncFiles(std::span<const fs::path> files) {
  // All are on their way before one is waited for: the first wait then writes down what they have
  // in common, and the others find it done. Where this cannot be asked, each waits for itself.
  for (const fs::path& file : files) {
    const FileDescriptor fd(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
    if (fd.get() >= 0) ::sync_file_range(fd.get(), 0, 0, SYNC_FILE_RANGE_WRITE);
  }
  for (const fs::path& file : files) {
    const FileDescriptor fd(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
    if (fd.get() < 0) return WriteError(file, "open", errno);
    if (::fsync(fd.get()) != 0) return WriteError(file, "write to disk", errno);
  }
  return Ok();
}

Status SyncFolder(const fs::path& folder) {
  const FileDescriptor fd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (fd.get() < 0) return WriteError(folder, "open folder", errno);
  // Some network file systems cannot sync folders; the rename is then as durable as they make it.
  if (::fsync(fd.get()) != 0 && errno != EINVAL && errno != ENOTSUP)
    return WriteError(folder, "sync folder", errno);
  return Ok();
}

Status RemoveAsideFiles(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> left;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    if (IsLeftAside(it->path().filename().string()) && it->is_regular_file(ignored))
      left.push_back(it->path());
  }
  for (const fs::path& file : left) {
    if (!fs::remove(file, error) && error) return WriteError(file, "remove", error.value());
  }
  return Ok();
}

Status MakeFolders(const fs::path& folder) {
  if (folder.empty()) return Ok();  // the parent of a name alone: where the program runs
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return WriteError(folder, "create folder", error.value());
  return Ok();
}

Result<std::string> HashFile(const fs::path& file) {
  const FileDescriptor fd(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  if (fd.get() < 0)
    return InvalidInput(fmt::format("{}: cannot open: {}", file.string(), std::strerror(errno)));
  Sha256 hash;
  std::vector<char> buffer(1U << 20);
  while (true) {
    const ssize_t got = ::read(fd.get(), buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0)
      return InvalidInput(fmt::format("{}: cannot read: {}", file.string(), std::strerror(errno)));
    if (got == 0) return hash.HexDigest();
    hash.Update({buffer.data(), static_cast<std::size_t>(got)});
  }
}

Result<std::string> HashFolder(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  // Folders that links lead to count as if they lay here.
  constexpr auto kFollow = fs::directory_options::follow_directory_symlink;
  for (fs::recursive_directory_iterator it(folder, kFollow, error), end; !error && it != end;
       it.increment(error)) {
    if (it->is_regular_file(error)) files.push_back(it->path());
  }
  if (error)
    return InvalidInput(fmt::format("{}: cannot list: {}", folder.string(), error.message()));
  std::sort(files.begin(), files.end());
  Sha256 hash;
  for (const fs::path& file : files) {
    const Result<std::string> digest = HashFile(file);
    if (!digest.ok()) return digest.error();
    hash.Update(fmt::format("{} {}\n", file.lexically_relative(folder).generic_string(), *digest));
  }
  return hash.HexDigest();
}

}  // namespace deepslam::storage
