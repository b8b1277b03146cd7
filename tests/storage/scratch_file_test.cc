#include "deepslam/storage/scratch_file.h"

#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "support/temp_dir.h"

namespace deepslam::storage {
namespace {

using testing::HasSubstr;
using testing_support::TempDir;

std::span<const std::byte> BytesOf(const std::string& text) {
  return std::as_bytes(std::span(text));
}

std::string Read(const ScratchFile& file, std::uint64_t at, std::size_t count) {
  std::string text(count, '?');
  file.Read(at, std::as_writable_bytes(std::span(text)));
  return text;
}

TEST(ScratchFile, GivesBackWhatItWasGivenAndHasNoName) {
  const TempDir dir;
  ScratchFile file(dir.path());
  ASSERT_TRUE(file.Append(BytesOf("one ")).ok());
  ASSERT_TRUE(file.Append(BytesOf("two")).ok());
  EXPECT_EQ(file.num_bytes(), 7u);
  EXPECT_EQ(Read(file, 0, 7), "one two");
  EXPECT_EQ(Read(file, 4, 3), "two");
  EXPECT_EQ(Read(file, 7, 0), "");
  EXPECT_FALSE(file.fault().has_value());
  EXPECT_TRUE(std::filesystem::is_empty(dir.path()));
}

TEST(ScratchFile, TwoInAFolderAreTwo) {
  const TempDir dir;
  ScratchFile one(dir.path());
  ScratchFile other(dir.path());
  ASSERT_TRUE(one.Append(BytesOf("one")).ok());
  ASSERT_TRUE(other.Append(BytesOf("two")).ok());
  EXPECT_EQ(Read(one, 0, 3), "one");
  EXPECT_EQ(Read(other, 0, 3), "two");
}

TEST(ScratchFile, WhatIsNotThereIsZeroAndAFaultThatStays) {
  const TempDir dir;
  ScratchFile file(dir.path());
  ASSERT_TRUE(file.Append(BytesOf("one")).ok());
  EXPECT_EQ(Read(file, 2, 3), std::string("e\0\0", 3));
  EXPECT_EQ(Read(file, 0, 3), "one") << "a later reading is sound again";
  ASSERT_TRUE(file.fault().has_value());
  EXPECT_EQ(file.fault()->code, ErrorCode::kFailed);
  EXPECT_THAT(file.fault()->message, HasSubstr(dir.path().string() + ": cannot read"));
}

TEST(ScratchFile, SaysWhyItCannotBeMade) {
  const TempDir dir;
  ScratchFile file(dir.path() / "missing");
  EXPECT_EQ(file.num_bytes(), 0u) << "nothing is made before there is something to hold";
  const Status status = file.Append(BytesOf("one"));
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().message,
              testing::AllOf(HasSubstr("missing: cannot create a temporary file"),
                             HasSubstr("No such file")));
}

TEST(ScratchFile, SaysThatItIsFull) {
  const TempDir dir;
  struct rlimit before {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
  const struct rlimit small { 4096, before.rlim_max };
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  ScratchFile file(dir.path());
  const Status status = file.Append(BytesOf(std::string(8192, 'x')));
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, ignored);
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().message,
              testing::AllOf(HasSubstr("cannot write a temporary file"), HasSubstr("ulimit -f")));
}

}  // namespace
}  // namespace deepslam::storage
