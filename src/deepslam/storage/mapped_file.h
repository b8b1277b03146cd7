// A large file that is read once, without a copy of it in memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <utility>

#include "deepslam/core/result.h"

namespace deepslam::storage {

// The bytes of a file as they are when it is opened. Of files that nobody writes into: what is cut
// off while it is read ends the program, as with every mapping; one that is replaced does no harm.
class MappedFile {
 public:
  // InvalidInput naming the file where it cannot be read or is no file; see ReadFile.
  [[nodiscard]] static Result<MappedFile> Open(const std::filesystem::path& file);

  MappedFile(MappedFile&& other) noexcept
      : begin_(std::exchange(other.begin_, nullptr)), size_(std::exchange(other.size_, 0)) {}
  MappedFile& operator=(MappedFile&& other) noexcept {
    std::swap(begin_, other.begin_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~MappedFile();

  [[nodiscard]] std::string_view bytes() const { return {begin_, size_}; }

 private:
  MappedFile(const char* begin, std::size_t size) : begin_(begin), size_(size) {}

  const char* begin_;  // null: empty
  std::size_t size_;
};

}  // namespace deepslam::storage
