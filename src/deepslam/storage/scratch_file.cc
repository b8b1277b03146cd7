#include "deepslam/storage/scratch_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace deepslam::storage {
namespace {

Error ScratchError(const std::filesystem::path& folder, std::string_view what, int error) {
  return Failed(fmt::format("{}: cannot {} a temporary file: {}{}",
                            folder.string(),
                            what,
                            std::strerror(error),
                            RemedyOf(error)));
}

}  // namespace

Status ScratchFile::Create() {
  // In place of the six X mkostemp puts letters that make the name a new one.
  std::string file = (folder_ / ".scratch-XXXXXX").string();
  FileDescriptor fd(::mkostemp(file.data(), O_CLOEXEC));
  if (fd.get() < 0 || ::unlink(file.c_str()) != 0) return ScratchError(folder_, "create", errno);
  fd_ = std::move(fd);
  return Ok();
}

Status ScratchFile::Append(std::span<const std::byte> bytes) {
  if (fd_.get() < 0) {
    if (Status status = Create(); !status.ok()) return status;
  }
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd_.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return ScratchError(folder_, "write", errno);
    num_bytes_ += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return Ok();
}

void ScratchFile::Read(std::uint64_t at, std::span<std::byte> into) const {
  while (!into.empty()) {
    const ssize_t got = ::pread(fd_.get(), into.data(), into.size(), static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!fault_) fault_ = ScratchError(folder_, "read", got < 0 ? errno : EIO);
      std::ranges::fill(into, std::byte{0});
      return;
    }
    at += static_cast<std::uint64_t>(got);
    into = into.subspan(static_cast<std::size_t>(got));
  }
}

std::optional<Error> ScratchFile::fault() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return fault_;
}

}  // namespace deepslam::storage
