#include "deepslam/dataset/read_bytes.h"

#include <sys/stat.h>

#include <cstdint>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/dataset/read_faults.h"
#include "support/temp_dir.h"

namespace deepslam::dataset {
namespace {

using testing::HasSubstr;
using namespace testing_support;  // NOLINT

TEST(ReadFilePiece, GivesWhatLiesThere) {
  const TempDir dir;
  WriteText(dir.path() / "file", "0123456789");
  EXPECT_EQ(*ReadFilePiece(dir.path() / "file", 3, 4), "3456");
  EXPECT_EQ(*ReadFilePiece(dir.path() / "file", 0, 10), "0123456789");
  EXPECT_EQ(*ReadFilePiece(dir.path() / "file", 10, 0), "");
  EXPECT_EQ(*ReadFileBytes(dir.path() / "file"), "0123456789");
}

TEST(ReadFilePiece, WhatIsNotThereIsAFaultOfTheFile) {
  const TempDir dir;
  WriteText(dir.path() / "file", "0123456789");
  for (const auto& [offset, num_bytes] : std::vector<std::pair<std::uint64_t, std::uint64_t>>{
           {3, 8}, {11, 0}, {0, 11}, {UINT64_MAX, 2}, {2, UINT64_MAX}}) {
    const Result<std::string> piece = ReadFilePiece(dir.path() / "file", offset, num_bytes);
    ASSERT_FALSE(piece.ok()) << offset << " " << num_bytes;
    EXPECT_EQ(piece.error().code, ErrorCode::kInvalidInput);
    EXPECT_THAT(piece.error().message, HasSubstr("ends too early"));
  }
  EXPECT_EQ(ReadFilePiece(dir.path() / "none", 0, 1).error().code, ErrorCode::kInvalidInput);
}

TEST(ReadFileBytes, PipesAreNotWaitedFor) {
  const TempDir dir;
  const std::filesystem::path pipe = dir.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(ReadFileBytes(pipe).error().message, HasSubstr("not a file"));
}

TEST(ReadFaults, KeepTheFirstFaultOfTheMachine) {
  ReadFaults faults;
  faults.Note(InvalidInput("a bad image"));
  EXPECT_FALSE(faults.first());
  faults.Note(Failed("the disk"));
  faults.Note(Failed("the disk again"));
  ASSERT_TRUE(faults.first());
  EXPECT_EQ(faults.first()->message, "the disk");
}

}  // namespace
}  // namespace deepslam::dataset
