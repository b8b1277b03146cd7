// Every file of tests/fuzz/corpus goes through its parser, with any compiler: seeds, what fuzzers
// kept, and the cases in which they found a fault (found_*).
#include <algorithm>
#include <array>
#include <filesystem>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "support/allocation_watch.h"
#include "support/temp_dir.h"

namespace deepslam::fuzz {

#define DEEPSLAM_PARSER(name) bool name(std::string_view bytes);
#include "parsers.inc"
#undef DEEPSLAM_PARSER

namespace {

namespace fs = std::filesystem;

// No file of a corpus is larger than some kilobytes; 64 MiB are the largest mask.
constexpr std::size_t kMaxAllocation = std::size_t{72} << 20;

struct Parser {
  std::string_view name;
  bool (*parse)(std::string_view bytes);
};

// For the names of failing tests.
void PrintTo(const Parser& parser, std::ostream* out) { *out << parser.name; }

constexpr auto kParsers = std::to_array<Parser>({
#define DEEPSLAM_PARSER(name) {#name, name},
#include "parsers.inc"
#undef DEEPSLAM_PARSER
});

class Replay : public testing::TestWithParam<Parser> {};

TEST_P(Replay, OfTheCorpus) {
  const fs::path folder = fs::path(DEEPSLAM_FUZZ_CORPUS) / GetParam().name;
  ASSERT_TRUE(fs::is_directory(folder)) << folder;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  int num_accepted = 0;
  for (const fs::path& file : files) {
    SCOPED_TRACE(file.string());
    const std::string bytes = testing_support::ReadText(file);
    testing_support::ForgetAllocations();
    num_accepted += GetParam().parse(bytes) ? 1 : 0;
    EXPECT_LE(testing_support::LargestAllocation(), kMaxAllocation);
  }
  // A corpus of refusals alone would lead no fuzzer into the parser.
  EXPECT_GT(num_accepted, 0);
}

// Beginnings of every file: what a parser meets that was cut off by a full disk or a lost
// connection.
TEST_P(Replay, OfWhatIsCutOff) {
  constexpr std::size_t kMostCuts = 64;
  const fs::path folder = fs::path(DEEPSLAM_FUZZ_CORPUS) / GetParam().name;
  for (const auto& entry : fs::directory_iterator(folder)) {
    SCOPED_TRACE(entry.path().string());
    const std::string bytes = testing_support::ReadText(entry.path());
    const std::size_t step = std::max<std::size_t>(1, bytes.size() / kMostCuts);
    for (std::size_t size = 0; size < bytes.size(); size += step)
      (void)GetParam().parse(std::string(bytes.data(), size));
  }
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Replay, testing::ValuesIn(kParsers), [](const auto& tested) {
  return std::string(tested.param.name);
});

}  // namespace
}  // namespace deepslam::fuzz
