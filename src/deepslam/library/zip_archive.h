// Reads entries of a zip file (Sweet Home 3D catalogues are zips).
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "deepslam/core/result.h"

namespace deepslam::library {

class ZipArchive {
 public:
  // Error: no such file, or not a zip.
  [[nodiscard]] static Result<ZipArchive> Open(const std::filesystem::path& file);
  ~ZipArchive();
  ZipArchive(ZipArchive&&) noexcept;
  ZipArchive& operator=(ZipArchive&&) noexcept;

  // The bytes of one entry. Error: no such entry, damaged, or larger than `max_bytes` when
  // unpacked.
  [[nodiscard]] Result<std::string> Read(std::string_view name, std::size_t max_bytes) const;

 private:
  struct Impl;
  explicit ZipArchive(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace deepslam::library
