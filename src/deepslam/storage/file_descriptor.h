// An open file, closed at the end of its scope.
#pragma once

#include <filesystem>
#include <string_view>
#include <utility>

#include <unistd.h>

#include "deepslam/core/result.h"

namespace deepslam::storage {

class FileDescriptor {
 public:
  explicit FileDescriptor(int fd) : fd_(fd) {}
  ~FileDescriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  [[nodiscard]] int get() const { return fd_; }
  int Close() { return ::close(std::exchange(fd_, -1)); }

 private:
  int fd_;
};

// What to do about an errno of writing, as the end of a message: "; free some space and run again".
[[nodiscard]] std::string_view RemedyOf(int error);

struct FileToRead {
  FileDescriptor fd;
  std::size_t num_bytes;  // when it was opened
};

// InvalidInput naming the file where it cannot be opened, is no regular file or is larger than
// kMaxFileBytes (store.h).
[[nodiscard]] Result<FileToRead> OpenToRead(const std::filesystem::path& file);

}  // namespace deepslam::storage
