// What a stage lays aside while it works, because it grows with the capture: a file that
// loses its name as soon as it is made, so that nothing is left of it however the process ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>

#include "deepslam/core/result.h"
#include "deepslam/storage/file_descriptor.h"

namespace deepslam::storage {

class ScratchFile {
 public:
  // In a folder that exists; messages name it.
  explicit ScratchFile(std::filesystem::path folder) : folder_(std::move(folder)), fd_(-1) {}

  // Behind what is there. One thread at a time, and none that reads.
  [[nodiscard]] Status Append(std::span<const std::byte> bytes);
  [[nodiscard]] std::uint64_t num_bytes() const { return num_bytes_; }

  // Fills `into` with what lies from `at` on. Thread-safe. Bytes that the machine does not give are
  // zero, and `fault` tells of it: what was made of them is nobody's result.
  void Read(std::uint64_t at, std::span<std::byte> into) const;
  [[nodiscard]] std::optional<Error> fault() const;

 private:
  [[nodiscard]] Status Create();

  std::filesystem::path folder_;
  FileDescriptor fd_;  // made when something is appended
  std::uint64_t num_bytes_ = 0;
  mutable std::mutex mutex_;
  mutable std::optional<Error> fault_;  // the first
};

}  // namespace deepslam::storage
