// The page over a batch: complete, self-contained, and safe against what captures are called.
#include <gmock/gmock.h>

#include "deepslam/report/batch_page.h"

namespace deepslam::report {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

BatchPage ThreeRooms() {
  BatchPage page;
  page.title = "rooms";
  page.tool_version = "1.2.3";
  page.when = "today";
  BatchRow done;
  done.name = "kitchen";
  done.state = "done";
  done.report_link = "kitchen/report/index.html";
  done.thumbnail.bytes = "jpeg";
  done.verdict = "doubtful";
  done.verdict_reasons = {"12 % of the frames could not be tracked"};
  done.objects = {{"chair", 3}, {"table", 1}};
  done.num_frames = 120;
  done.ate_m = 0.0125;
  done.num_scored = 118;
  done.num_estimated = 120;
  done.wall_s = 71;
  done.megabytes = 12.5;
  BatchRow failed;
  failed.name = "office";
  failed.state = "failed";
  failed.failure = "capture.yaml:3: fx is 0\nwrite the camera's values";
  failed.log_link = ".batch/logs/office.log";
  BatchRow waiting;
  waiting.name = "hall";
  waiting.state = "waiting";
  page.rows = {done, failed, waiting};
  return page;
}

int CountOf(const std::string& text, const std::string& what) {
  int count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
    ++count;
  return count;
}

TEST(BatchPage, TellsEverythingOfARow) {
  const std::string html = RenderBatchPage(ThreeRooms());
  EXPECT_THAT(html, HasSubstr("href='kitchen/report/index.html'"));
  EXPECT_THAT(html, HasSubstr("data:image/jpeg;base64,anBlZw=="));
  EXPECT_THAT(html, AllOf(HasSubstr("doubtful"), HasSubstr("12 % of the frames")));
  EXPECT_THAT(html, AllOf(HasSubstr("3 chair, 1 table"), HasSubstr("118 of 120 frames")));
  EXPECT_THAT(html, AllOf(HasSubstr("0.013 m"), HasSubstr("12.5 MB"), HasSubstr("1.2 min")));
  EXPECT_THAT(html, AllOf(HasSubstr("capture.yaml:3: fx is 0"), HasSubstr("office.log")));
  EXPECT_EQ(CountOf(html, "<tr data-kind="), 3);
}

TEST(BatchPage, NamesAndReasonsCannotBecomeMarkup) {
  BatchPage page = ThreeRooms();
  page.title = "<script>alert(1)</script>";
  for (BatchRow& row : page.rows) {
    row.name = "'><img src=x onerror=alert(1)>";
    row.report_link = "a' onclick='x/report/index.html";
    row.failure = "<b>bold</b>";
    row.verdict_reasons = {"</ul><script>alert(2)</script>"};
    row.objects = {{"<i>chair", 1}};
  }
  const std::string html = RenderBatchPage(page);
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(html, Not(HasSubstr("<img src=x")));
  EXPECT_THAT(html, Not(HasSubstr("onclick='")));
  EXPECT_THAT(html, Not(HasSubstr("<b>bold")));
  EXPECT_THAT(html, Not(HasSubstr("<i>")));
}

TEST(BatchPage, LinksOfAnyNameAreEscaped) {
  BatchPage page = ThreeRooms();
  page.rows[0].report_link = "k\xC3\xBC#1/report/index.html";
  EXPECT_THAT(RenderBatchPage(page), HasSubstr("href='k%C3%BC%231/report/index.html'"));
}

TEST(BatchPage, NeedsNothingFromElsewhere) {
  const std::string html = RenderBatchPage(ThreeRooms());
  EXPECT_THAT(html, Not(HasSubstr("http://")));
  EXPECT_THAT(html, Not(HasSubstr("https://")));
}

TEST(BatchPage, AThousandCapturesAreAFewMegabytes) {
  BatchPage page = ThreeRooms();
  page.rows[0].thumbnail.bytes = std::string(6000, 'x');
  page.rows.resize(1);
  page.rows.resize(1000, page.rows[0]);
  EXPECT_LT(RenderBatchPage(page).size(), 12'000'000U);
}

}  // namespace
}  // namespace deepslam::report
