#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/core/sha256.h"
#include "deepslam/storage/mapped_file.h"
#include "deepslam/storage/store.h"
#include "support/temp_dir.h"

namespace deepslam::storage {
namespace {

using testing::HasSubstr;
using testing_support::ReadText;
using testing_support::TempDir;
using testing_support::WriteText;

TEST(Store, WritesWholeFilesAndLeavesNothingAside) {
  const TempDir dir;
  const auto file = dir.path() / "a.json";
  WriteText(file, "old");
  ASSERT_TRUE(WriteFileAtomically(file, "new").ok());
  EXPECT_EQ(ReadText(file), "new");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(dir.path()), {}), 1);
}

TEST(Store, KeepsTheOldFileWhenTheNewOneCannotBeWritten) {
  const TempDir dir;
  const Status status = WriteFileAtomically(dir.path() / "missing" / "a.json", "new");
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kFailed);
  EXPECT_THAT(status.error().message,
              testing::AllOf(HasSubstr("a.json: cannot create"),
                             HasSubstr("No such file"),
                             HasSubstr("make its folder first")));
}

TEST(Store, GivesATextByPieces) {
  const TempDir dir;
  const auto file = dir.path() / "a.txt";
  std::string text;
  for (int k = 0; k < 200'000; ++k) text += "line " + std::to_string(k) + "\n";
  for (const std::string& whole : {std::string(), std::string("short"), text}) {
    WriteText(file, whole);
    Result<TextSource> opened = OpenText(file);
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    std::string read;
    while (true) {
      const Result<std::string_view> piece = opened->Next();
      ASSERT_TRUE(piece.ok()) << piece.error().message;
      if (piece->empty()) break;
      EXPECT_LT(piece->size(), std::size_t{1} << 20) << "not all of a long text";
      read += *piece;
    }
    EXPECT_EQ(read, whole);
    EXPECT_TRUE(opened->Next()->empty()) << "it stays at its end";
  }
  const Result<TextSource> missing = OpenText(dir.path() / "missing.txt");
  ASSERT_FALSE(missing.ok());
  EXPECT_THAT(missing.error().message, HasSubstr("missing.txt"));
}

TEST(Store, WritesIntoPipesAndLeavesThemPipes) {
  const TempDir dir;
  const auto pipe = dir.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  EXPECT_TRUE(WriteFileAtomically(pipe, "bytes").ok());
  std::string got(16, ' ');
  got.resize(
      static_cast<std::size_t>(std::max<ssize_t>(0, ::read(reader, got.data(), got.size()))));
  ::close(reader);
  EXPECT_EQ(got, "bytes");
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

TEST(Store, ReplacesWhatALinkLeadsToAndLeavesTheLink) {
  const TempDir dir;
  const auto link = dir.path() / "latest.json";
  WriteText(dir.path() / "real" / "a.json", "old");
  std::filesystem::create_symlink("real/a.json", link);
  ASSERT_TRUE(WriteFileAtomically(link, "new").ok());
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(ReadText(dir.path() / "real" / "a.json"), "new");
  std::filesystem::remove(dir.path() / "real" / "a.json");
  ASSERT_TRUE(WriteFileAtomically(link, "newer").ok());
  EXPECT_EQ(ReadText(dir.path() / "real" / "a.json"), "newer");
}

TEST(Store, NamesAFullDisk) {
  if (::access("/dev/full", W_OK) != 0) GTEST_SKIP() << "no /dev/full here";
  const Status status = WriteFileSynced("/dev/full", "bytes");
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().message,
              testing::AllOf(HasSubstr("No space left"), HasSubstr("free some space")));
}

TEST(Store, SyncsFilesThatWereWrittenBefore) {
  const TempDir dir;
  const std::vector<std::filesystem::path> files = {dir.path() / "a", dir.path() / "b"};
  for (const std::filesystem::path& file : files) EXPECT_TRUE(WriteFileUnsynced(file, "x").ok());
  EXPECT_TRUE(SyncFiles(files).ok());
  EXPECT_EQ(*ReadFile(files[1]), "x");
  std::filesystem::remove(files[1]);
  EXPECT_THAT(SyncFiles(files).error().message,
              testing::AllOf(HasSubstr("b: cannot open"), HasSubstr("No such file")));
}

TEST(Store, RefusesFoldersAndMissingFiles) {
  const TempDir dir;
  EXPECT_THAT(ReadFile(dir.path()).error().message, HasSubstr("is not a file"));
  EXPECT_EQ(ReadFile(dir.path() / "none").error().code, ErrorCode::kInvalidInput);
}

TEST(MappedFile, HoldsTheBytesOfAFile) {
  const TempDir dir;
  const std::string text(100'000, 'x');
  WriteText(dir.path() / "large", text);
  WriteText(dir.path() / "empty", "");
  Result<MappedFile> large = MappedFile::Open(dir.path() / "large");
  ASSERT_TRUE(large.ok());
  std::filesystem::remove(dir.path() / "large");
  const MappedFile moved = std::move(large).value();
  EXPECT_EQ(moved.bytes(), text);
  const Result<MappedFile> empty = MappedFile::Open(dir.path() / "empty");
  ASSERT_TRUE(empty.ok());
  EXPECT_TRUE(empty->bytes().empty());
}

TEST(MappedFile, RefusesWhatReadFileRefuses) {
  const TempDir dir;
  for (const std::filesystem::path& file : {dir.path(), dir.path() / "none"})
    EXPECT_EQ(MappedFile::Open(file).error().message, ReadFile(file).error().message);
}

TEST(Store, HashesContentNotPlace) {
  const TempDir a;
  const TempDir b;
  for (const TempDir* dir : {&a, &b}) {
    WriteText(dir->path() / "x" / "1", "one");
    WriteText(dir->path() / "2", "two");
  }
  EXPECT_EQ(*HashFolder(a.path()), *HashFolder(b.path()));
  EXPECT_EQ(*HashFile(a.path() / "2"), Sha256Hex("two"));
  // What a link leads to counts as if it lay here, wherever it lies.
  const TempDir linked;
  WriteText(linked.path() / "2", "two");
  std::filesystem::create_directory_symlink(a.path() / "x", linked.path() / "x");
  EXPECT_EQ(*HashFolder(linked.path()), *HashFolder(a.path()));
  WriteText(a.path() / "x" / "1", "other");
  EXPECT_EQ(*HashFolder(linked.path()), *HashFolder(a.path()));
  EXPECT_NE(*HashFolder(linked.path()), *HashFolder(b.path()));
  WriteText(b.path() / "2", "three");
  EXPECT_NE(*HashFolder(a.path()), *HashFolder(b.path()));
}

}  // namespace
}  // namespace deepslam::storage
