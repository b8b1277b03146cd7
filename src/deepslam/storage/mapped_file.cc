#include "deepslam/storage/mapped_file.h"

#include <sys/mman.h>

#include <cerrno>
#include <cstring>

#include <fmt/format.h>

#include "deepslam/storage/file_descriptor.h"

namespace deepslam::storage {

Result<MappedFile> MappedFile::Open(const std::filesystem::path& file) {
  const Result<FileToRead> opened = OpenToRead(file);
  if (!opened.ok()) return opened.error();
  const std::size_t size = opened->num_bytes;
  if (size == 0) return MappedFile(nullptr, 0);
  void* const begin =
      ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE | MAP_POPULATE, opened->fd.get(), 0);
  if (begin == MAP_FAILED)
    return InvalidInput(fmt::format("{}: cannot read: {}", file.string(), std::strerror(errno)));
  return MappedFile(static_cast<const char*>(begin), size);
}

MappedFile::~MappedFile() {
  if (begin_ != nullptr) ::munmap(const_cast<char*>(begin_), size_);
}

}  // namespace deepslam::storage
