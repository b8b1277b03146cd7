// Bytes of files, with what the file holds told apart from what the machine does: a file that is
// missing, too short or not allowed is kInvalidInput; one that is there and whose disk or network
// fails is kFailed, since another attempt may well read it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "deepslam/core/result.h"

namespace deepslam::dataset {

// All bytes of a file of at most `max_bytes`.
[[nodiscard]] Result<std::string> ReadFileBytes(const std::filesystem::path& file,
                                                std::uintmax_t max_bytes = 256u << 20);

// The text of a file, as UTF-8 (core/utf8.h).
[[nodiscard]] Result<std::string> ReadTextFile(const std::filesystem::path& file);

// `num_bytes` from `offset` on; kInvalidInput when the file ends before.
[[nodiscard]] Result<std::string> ReadFilePiece(const std::filesystem::path& file,
                                                std::uint64_t offset,
                                                std::uint64_t num_bytes);

}  // namespace deepslam::dataset
