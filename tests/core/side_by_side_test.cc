#include "deepslam/core/side_by_side.h"

#include <array>
#include <string>

#include <gtest/gtest.h>

namespace deepslam {
namespace {

TEST(RunSideBySide, RunsAll) {
  int number = 0;
  std::string word;
  const std::array<std::function<Status()>, 2> tasks = {
      [&] { return Take(Result<int>(7), number); },
      [&] { return Take(Result<std::string>("seven"), word); }};
  EXPECT_TRUE(RunSideBySide(tasks).ok());
  EXPECT_EQ(number, 7);
  EXPECT_EQ(word, "seven");
}

TEST(RunSideBySide, GivesTheFirstErrorWhoeverIsDoneFirst) {
  int number = 0;
  const std::array<std::function<Status()>, 3> tasks = {
      [&] { return Take(Result<int>(7), number); },
      [] { return Status(InvalidInput("second")); },
      [] { return Status(InvalidInput("third")); }};
  for (int turn = 0; turn < 50; ++turn) EXPECT_EQ(RunSideBySide(tasks).error().message, "second");
}

}  // namespace
}  // namespace deepslam
