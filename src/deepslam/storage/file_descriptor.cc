#include "deepslam/storage/file_descriptor.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>

#include <fmt/format.h>

#include "deepslam/storage/store.h"

namespace deepslam::storage {

namespace fs = std::filesystem;

Result<FileToRead> OpenToRead(const fs::path& file) {
  FileDescriptor fd(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  if (fd.get() < 0)
    return InvalidInput(fmt::format("{}: cannot open: {}", file.string(), std::strerror(errno)));
  struct stat status {};
  if (::fstat(fd.get(), &status) != 0 || !S_ISREG(status.st_mode)) {
    return InvalidInput(fmt::format("{}: is not a file", file.string()));
  }
  if (static_cast<std::uintmax_t>(status.st_size) > kMaxFileBytes) {
    return InvalidInput(fmt::format("{}: {} bytes are more than the {} that are read",
                                    file.string(),
                                    status.st_size,
                                    kMaxFileBytes));
  }
  return FileToRead{std::move(fd), static_cast<std::size_t>(status.st_size)};
}

std::string_view RemedyOf(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
      return "; free some space and run again";
    case EFBIG:
      return "; raise the limit on file sizes (ulimit -f) and run again";
    case EROFS:
      return "; choose a folder on a writable file system";
    case ENOENT:
      return "; make its folder first";
    case EACCES:
    case EPERM:
      return "; choose a folder you may write to, or change its permissions";
    default:
      return "";
  }
}

}  // namespace deepslam::storage
