#include "deepslam/dataset/read_bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string_view>

#include <fmt/format.h>

#include "deepslam/core/utf8.h"

namespace deepslam::dataset {
namespace {

namespace fs = std::filesystem;

class OpenFile {
 public:
  explicit OpenFile(const fs::path& file) : fd_(::open(file.c_str(), O_RDONLY | O_CLOEXEC)) {}
  ~OpenFile() {
    if (fd_ >= 0) ::close(fd_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

Error FileError(const fs::path& file, std::string_view fault) {
  return InvalidInput(fmt::format("{}: {}", file.string(), fault));
}

Error MachineError(const fs::path& file, int error) {
  return Failed(
      fmt::format("{}: cannot be read: {}; see to the disk or the network it lies on, or copy the "
                  "capture elsewhere, and run again",
                  file.string(),
                  std::strerror(error)));
}

// What opening a file says of the file itself; all else is the machine's.
Error OpenError(const fs::path& file, int error) {
  switch (error) {
    case ENOENT:
      return FileError(file, "file is missing");
    case ENOTDIR:
    case ELOOP:
    case ENAMETOOLONG:
      return FileError(file, fmt::format("cannot be read ({})", std::strerror(error)));
    case EACCES:
    case EPERM:
      return FileError(file, "cannot be read; check its permissions");
    default:
      return MachineError(file, error);
  }
}

// `num_bytes` of an open file; fewer where it ends before.
Result<std::string> ReadOpen(const OpenFile& open,
                             const fs::path& file,
                             std::uint64_t offset,
                             std::uint64_t num_bytes) {
  std::string bytes(num_bytes, '\0');
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got = ::pread(
        open.get(), bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return MachineError(file, errno);
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  bytes.resize(done);
  return bytes;
}

// Size of an open file; an error when it is none.
Result<std::uintmax_t> SizeOf(const OpenFile& open, const fs::path& file) {
  struct stat status {};
  if (::fstat(open.get(), &status) != 0) return MachineError(file, errno);
  if (!S_ISREG(status.st_mode)) return FileError(file, "not a file");
  return static_cast<std::uintmax_t>(status.st_size);
}

}  // namespace

Result<std::string> ReadFileBytes(const fs::path& file, std::uintmax_t max_bytes) {
  // Pipes are not opened: that would wait for a writer.
  std::error_code code;
  const fs::file_status status = fs::status(file, code);
  if (fs::exists(status) && !fs::is_regular_file(status)) return FileError(file, "not a file");
  const OpenFile open(file);
  if (open.get() < 0) return OpenError(file, errno);
  const Result<std::uintmax_t> size = SizeOf(open, file);
  if (!size) return size.error();
  if (*size > max_bytes)
    return FileError(
        file, fmt::format("has {} bytes, more than the {} expected at most", *size, max_bytes));
  Result<std::string> bytes = ReadOpen(open, file, 0, *size);
  if (bytes && bytes->size() != *size) return FileError(file, "became shorter while it was read");
  return bytes;
}

Result<std::string> ReadTextFile(const fs::path& file) {
  Result<std::string> bytes = ReadFileBytes(file);
  if (!bytes) return bytes;
  return Utf8OfText(*std::move(bytes));
}

Result<std::string> ReadFilePiece(const fs::path& file,
                                  std::uint64_t offset,
                                  std::uint64_t num_bytes) {
  const OpenFile open(file);
  if (open.get() < 0) return OpenError(file, errno);
  const Result<std::uintmax_t> size = SizeOf(open, file);
  if (!size) return size.error();
  if (offset > *size || num_bytes > *size - offset)
    return FileError(file, "ends too early; was it changed?");
  Result<std::string> bytes = ReadOpen(open, file, offset, num_bytes);
  if (bytes && bytes->size() != num_bytes)
    return FileError(file, "ends too early; was it changed?");
  return bytes;
}

}  // namespace deepslam::dataset
