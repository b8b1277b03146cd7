// What networks and libraries hold, as SHA-256, computed once in a process while their files stay
// the same.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "deepslam/core/result.h"

namespace deepslam::stages {

// What a file, or all files below a folder, look like from outside: equal while their paths, sizes,
// inodes and times of change are.
[[nodiscard]] std::string StateOf(const std::filesystem::path& file_or_folder);

// For one thread at a time. Files are taken as unchanged while StateOf() is.
class ContentHashes {
 public:
  // Of a file's bytes, or of names and bytes of a folder's files (storage::HashFile, HashFolder).
  [[nodiscard]] Result<std::string> Of(const std::filesystem::path& file_or_folder);

 private:
  struct Known {
    std::string state;
    std::string hash;
  };
  std::map<std::filesystem::path, Known> known_;
};

}  // namespace deepslam::stages
