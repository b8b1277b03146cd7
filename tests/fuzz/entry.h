// What the fuzzers and the replay of their corpora share: one function per parser, bytes in.
//
// A parser's file (parsers/NAME.cc) defines
//   DEEPSLAM_FUZZ(NAME) { ... bytes ... return accepted; }
// which hands the bytes to the parser as a user's file would and asks of what comes back whatever
// must always hold: a refusal names the file, a value that was read can be written and reads back
// as the same. A breach is a DEEPSLAM_CHECK, so it ends the fuzzer as a bad access does.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>

#include "deepslam/core/check.h"
#include "deepslam/core/result.h"

// True: the bytes were accepted.
#define DEEPSLAM_FUZZ(parser)          \
  namespace deepslam::fuzz {           \
  bool parser(std::string_view bytes); \
  }                                    \
  bool deepslam::fuzz::parser(         \
      [[maybe_unused]] std::string_view bytes)  // NOLINT(misc-use-internal-linkage)

namespace deepslam::fuzz {

// The name that parsers are told.
inline constexpr std::string_view kFile = "folder/input.file";

// A message that a user can act on names the file, and is short enough to be read.
inline bool Refused(const Error& error, std::string_view file = kFile) {
  constexpr std::size_t kMaxMessageBytes = 1 << 20;
  DEEPSLAM_CHECK(error.message.find(file) != std::string::npos,
                 "a refusal names the file: " + error.message);
  DEEPSLAM_CHECK(error.message.size() < kMaxMessageBytes, "a refusal can be read");
  return false;
}

// Whether a path that an input names is one below the input's folder.
inline bool StaysBelow(std::string_view name) {
  const std::filesystem::path path(name);
  return path.is_relative() && !name.empty() &&
         std::none_of(path.begin(), path.end(), [](const auto& part) { return part == ".."; });
}

// Decode, Encode: of one value, as the rooms have them, with the name for messages. Writing and
// reading again ends in the same text.
template <typename Decode, typename Encode>
bool RoundTrip(std::string_view bytes, Decode decode, Encode encode) {
  const auto value = decode(bytes, kFile);
  if (!value.ok()) return Refused(value.error());
  const Result<std::string> once = encode(*value, kFile);
  DEEPSLAM_CHECK(once.ok(),
                 "what was read can be written: " + (once.ok() ? "" : once.error().message));
  const auto again = decode(*once, kFile);
  DEEPSLAM_CHECK(again.ok(),
                 "what was written can be read: " + (again.ok() ? "" : again.error().message));
  const Result<std::string> twice = encode(*again, kFile);
  DEEPSLAM_CHECK(twice.ok() && *once == *twice, "reading what was written changes nothing");
  return true;
}

}  // namespace deepslam::fuzz
