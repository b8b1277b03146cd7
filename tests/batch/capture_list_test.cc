// Lists, patterns, and names of workspaces.
#include <gmock/gmock.h>

#include "deepslam/batch/capture_list.h"
#include "support/temp_dir.h"

namespace deepslam::batch {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing_support::TempDir;
using testing_support::WriteText;
namespace fs = std::filesystem;

std::vector<std::string> Names(const std::vector<ListedCapture>& captures) {
  std::vector<std::string> names;
  for (const ListedCapture& capture : captures) names.push_back(capture.name);
  return names;
}

std::vector<ListedCapture> Read(std::string_view text) {
  const auto captures = ReadCaptureList(text, "rooms.txt", "/data");
  EXPECT_TRUE(captures.ok()) << captures.error().message;
  return captures.ok() ? *captures : std::vector<ListedCapture>();
}

std::string Refusal(std::string_view text) {
  const auto captures = ReadCaptureList(text, "rooms.txt", "/data");
  if (captures.ok()) return "was read";
  EXPECT_EQ(captures.error().code, ErrorCode::kInvalidInput);
  return captures.error().message;
}

TEST(CaptureList, OneCapturePerLineWithCommentsAndNames) {
  const auto captures = Read(
      "\xEF\xBB\xBF# all rooms\r\n"
      "kitchen   # the small one\r\n"
      "\n"
      "  ../other/office  office_2\n"
      "\"two words/room 3\"\n"
      "/abs/scene.sens\n");
  EXPECT_THAT(Names(captures), ElementsAre("kitchen", "office_2", "room_3", "scene"));
  EXPECT_EQ(captures[0].path, "/data/kitchen");
  EXPECT_EQ(captures[1].path, "/other/office");
  EXPECT_EQ(captures[2].path, "/data/two words/room 3");
  EXPECT_EQ(captures[1].place, "rooms.txt:4");
}

TEST(CaptureList, FaultsNameTheLine) {
  EXPECT_THAT(Refusal("a\nb b2 b3\n"), AllOf(HasSubstr("rooms.txt:2"), HasSubstr("quotes")));
  EXPECT_THAT(Refusal("\"open\n"), AllOf(HasSubstr("rooms.txt:1"), HasSubstr("not closed")));
  EXPECT_THAT(Refusal("a ../b\n"), AllOf(HasSubstr("'../b'"), HasSubstr("cannot name")));
  EXPECT_THAT(Refusal("a .hidden\n"), HasSubstr("cannot name"));
  EXPECT_THAT(Refusal("# nothing\n\n"), HasSubstr("names no capture"));
  EXPECT_THAT(Refusal(""), HasSubstr("names no capture"));
  EXPECT_THAT(Refusal("none/*\n"), AllOf(HasSubstr("rooms.txt:1"), HasSubstr("matches no")));
  EXPECT_THAT(Refusal("none/* name\n"), HasSubstr("can have no name"));
  EXPECT_THAT(Refusal(std::string_view("\x89PNG\0\0\0", 7)), HasSubstr("is no text"));
}

TEST(CaptureList, NamesDependOnTheirOwnEntryAlone) {
  const auto few = Read("b/seq-01\n");
  const auto many = Read("a/seq-02\nb/seq-01\nc/seq-03\n");
  EXPECT_EQ(few[0].name, many[1].name);
}

TEST(CaptureList, StrangeNamesBecomeNamesOfFolders) {
  EXPECT_THAT(Names(Read("\"x/a b;c\"\n.hidden\n-rf\nk\xC3\xBC"
                         "che\nx/\n")),
              ElementsAre("a_b_c",
                          "_hidden",
                          "_rf",
                          "k\xC3\xBC"
                          "che",
                          "x"));
}

class Folders : public testing::Test {
 protected:
  Folders() {
    for (const char* folder :
         {"rooms/kitchen/seq-01", "rooms/kitchen/seq-02", "rooms/office/seq-01"})
      fs::create_directories(dir.path() / folder);
    WriteText(dir.path() / "rooms" / "readme.txt", "x");
    WriteText(dir.path() / "rooms" / "scan.sens", "x");
  }
  std::string At(const std::string& path) const { return (dir.path() / path).string(); }
  TempDir dir;
};

TEST_F(Folders, PatternsNameByWhatTheyMatch) {
  const std::vector<std::string> arguments = {At("rooms/*/seq-*")};
  const auto captures = FindCaptures(arguments);
  ASSERT_TRUE(captures.ok()) << captures.error().message;
  EXPECT_THAT(Names(*captures), ElementsAre("kitchen_seq-01", "kitchen_seq-02", "office_seq-01"));
}

TEST_F(Folders, PatternsTakeFoldersAndRecordingsOnly) {
  const std::vector<std::string> arguments = {At("rooms/*")};
  const auto captures = FindCaptures(arguments);
  ASSERT_TRUE(captures.ok()) << captures.error().message;
  EXPECT_THAT(Names(*captures), ElementsAre("kitchen", "office", "scan"));
}

TEST_F(Folders, TheFolderOfAListIsNoPattern) {
  fs::rename(dir.path() / "rooms", dir.path() / "[a]*");
  const auto captures = ReadCaptureList("*/seq-01\n", "list.txt", dir.path() / "[a]*");
  ASSERT_TRUE(captures.ok()) << captures.error().message;
  EXPECT_THAT(Names(*captures), ElementsAre("kitchen_seq-01", "office_seq-01"));
  EXPECT_TRUE(captures->front().by_pattern);
}

TEST_F(Folders, ListsCapturesAndPatternsMix) {
  WriteText(dir.path() / "list.txt", "rooms/kitchen/seq-01 first\nmissing\nrooms/office/*\n");
  const std::vector<std::string> arguments = {
      At("list.txt"), At("rooms/kitchen/"), At("rooms/scan.sens")};
  const auto captures = FindCaptures(arguments);
  ASSERT_TRUE(captures.ok()) << captures.error().message;
  EXPECT_THAT(Names(*captures), ElementsAre("first", "missing", "seq-01", "kitchen", "scan"));
  EXPECT_EQ((*captures)[3].path, At("rooms/kitchen"));
}

TEST_F(Folders, CollisionsAreToldWithBothPlaces) {
  const std::vector<std::string> arguments = {At("rooms/kitchen/seq-01"),
                                              At("rooms/office/seq-01")};
  const auto captures = FindCaptures(arguments);
  ASSERT_FALSE(captures.ok());
  EXPECT_EQ(captures.error().code, ErrorCode::kInvalidInput);
  EXPECT_THAT(captures.error().message,
              AllOf(HasSubstr("argument 1"),
                    HasSubstr("argument 2"),
                    HasSubstr("'seq-01'"),
                    HasSubstr("PATH NAME")));
  const std::vector<std::string> twice = {At("rooms/office"), At("rooms/office/")};
  EXPECT_THAT(FindCaptures(twice).error().message, HasSubstr("stands twice"));
}

TEST_F(Folders, MissingAndUnusableNamesAreRefused) {
  const std::vector<std::string> missing = {At("none.txt")};
  EXPECT_THAT(FindCaptures(missing).error().message, HasSubstr("no such list"));
  WriteText(dir.path() / "list.txt", "rooms/kitchen batch.json\n");
  const std::vector<std::string> reserved = {At("list.txt")};
  EXPECT_THAT(FindCaptures(reserved).error().message, HasSubstr("cannot name a workspace"));
  WriteText(dir.path() / "list.txt", "rooms/\xFF\xFE\n");
  EXPECT_THAT(FindCaptures(reserved).error().message, HasSubstr("UTF-8"));
}

}  // namespace
}  // namespace deepslam::batch
