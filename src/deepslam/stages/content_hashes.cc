#include "deepslam/stages/content_hashes.h"

#include <sys/stat.h>

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "deepslam/storage/store.h"

namespace deepslam::stages {
namespace {

namespace fs = std::filesystem;

std::string FileState(const fs::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return "missing";
  return fmt::format("{} {}:{} {} {}.{} {}.{}",
                     file.string(),
                     status.st_dev,
                     status.st_ino,
                     status.st_size,
                     status.st_mtim.tv_sec,
                     status.st_mtim.tv_nsec,
                     status.st_ctim.tv_sec,
                     status.st_ctim.tv_nsec);
}

}  // namespace

std::string StateOf(const fs::path& file_or_folder) {
  std::error_code error;
  if (!fs::is_directory(file_or_folder, error)) return FileState(file_or_folder);
  std::vector<std::string> states;
  for (fs::recursive_directory_iterator it(file_or_folder, error), end; !error && it != end;
       it.increment(error)) {
    states.push_back(FileState(it->path()));
  }
  std::sort(states.begin(), states.end());
  std::string all;
  for (const std::string& state : states) all += state + '\n';
  return all;
}

Result<std::string> ContentHashes::Of(const fs::path& file_or_folder) {
  const std::string state = StateOf(file_or_folder);
  Known& known = known_[file_or_folder];
  if (known.state == state && !known.hash.empty()) return known.hash;
  std::error_code error;
  Result<std::string> hash = fs::is_directory(file_or_folder, error)
                                 ? storage::HashFolder(file_or_folder)
                                 : storage::HashFile(file_or_folder);
  if (hash.ok()) known = {state, *hash};
  return hash;
}

}  // namespace deepslam::stages
