// Texts that come by pieces say what the whole of them says, wherever a piece ends.
#include "deepslam/core/text_pieces.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>

#include "artifact/sample_values.h"
#include "deepslam/artifact/json_value.h"
#include "deepslam/artifact/objects_json.h"
#include "deepslam/artifact/pose_graph_g2o.h"
#include "deepslam/artifact/trajectory_files.h"
#include "support/text_in_pieces.h"

namespace deepslam::artifact {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using namespace deepslam::testing_support;  // NOLINT(google-build-using-namespace)

constexpr std::size_t kPieceSizes[] = {1, 2, 3, 7, 64, 1000, 1 << 20};

// Fails instead of ending.
TextSource Torn(const std::string& text) {
  return TextSource([text, is_given = false]() mutable -> Result<std::string_view> {
    if (is_given) return InvalidInput("disk: cannot read");
    is_given = true;
    return std::string_view(text);
  });
}

Result<std::vector<std::string>> Lines(TextSource text) {
  std::vector<std::string> lines;
  const Status status = ForLines(std::move(text), "f", [&](std::string_view line) {
    lines.emplace_back(line);
    return Ok();
  });
  if (!status.ok()) return status.error();
  return lines;
}

TEST(ForLines, GivesEveryLineWhereverPiecesEnd) {
  for (const std::size_t size : kPieceSizes) {
    EXPECT_THAT(*Lines(InPieces("first\n\nthird line\nlast", size)),
                ElementsAre("first", "", "third line", "last"));
    EXPECT_THAT(*Lines(InPieces("first\nlast\n", size)), ElementsAre("first", "last"));
    EXPECT_THAT(*Lines(InPieces("\n\n", size)), ElementsAre("", ""));
    EXPECT_THAT(*Lines(InPieces("", size)), ElementsAre());
  }
}

TEST(ForLines, TellsTheLineAndEndsThere) {
  for (const std::size_t size : kPieceSizes) {
    int num_lines = 0;
    const Status status =
        ForLines(InPieces("a\nb\nc\nd\n", size), "f.txt", [&](std::string_view line) {
          ++num_lines;
          return line == "c" ? Status(InvalidInput("is no letter")) : Ok();
        });
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().message, "f.txt:3: is no letter");
    EXPECT_EQ(num_lines, 3);
  }
}

TEST(ForLines, PassesOnWhatIsWrongWithTheText) {
  const auto lines = Lines(Torn("a\nb"));
  ASSERT_FALSE(lines.ok());
  EXPECT_EQ(lines.error().message, "disk: cannot read");
}

// Numbers, strings with escapes and words are cut anywhere.
TEST(JsonByPieces, IsReadAsTheWhole) {
  const std::string text =
      R"({"a": [1, -2.5e-3, true, null, "\u00e4\"\\ ä"], "b": {"c": [[], {}]}})";
  const std::string whole = *DumpJson(*ParseJson(text, "f"), "f");
  const std::string objects = *EncodeObjectMap(SampleObjects(), "f");
  for (const std::size_t size : kPieceSizes) {
    const auto read = ParseJson(InPieces(text, size), "f");
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(*DumpJson(*read, "f"), whole);
    const Result<ObjectMap> map = DecodeObjectMap(InPieces(objects, size), "f");
    ASSERT_TRUE(map.ok()) << map.error().message;
    EXPECT_EQ(*EncodeObjectMap(*map, "f"), objects);
  }
}

TEST(JsonByPieces, FaultsAreThoseOfTheWhole) {
  for (const std::string text :
       {"", "{", "[1,\n 2,\n x]", "[1] 2", "{\"a\": 1e999}", "[\"\xff\"]"}) {
    const auto whole = ParseJson(text, "f");
    ASSERT_FALSE(whole.ok()) << text;
    for (const std::size_t size : kPieceSizes) {
      const auto read = ParseJson(InPieces(text, size), "f");
      ASSERT_FALSE(read.ok()) << text;
      EXPECT_EQ(read.error().message, whole.error().message);
    }
  }
}

TEST(JsonByPieces, PassesOnWhatIsWrongWithTheText) {
  for (const std::string text : {"{\"a\": [1, 2", "[1]"}) {
    const auto read = ParseJson(Torn(text), "f");
    ASSERT_FALSE(read.ok()) << text;
    EXPECT_EQ(read.error().message, "disk: cannot read");
  }
}

// Rows are written as they are made, and short ones are joined into one line across the ends of
// pieces as elsewhere.
TEST(JsonByPieces, IsWrittenAsTheWhole) {
  JsonArray array;
  for (int k = 0; k < 20'000; ++k) {
    JsonObject row;
    row.emplace("number", k);
    if (k % 3 == 0) row.emplace("long", std::string(static_cast<std::size_t>(k % 400), 'x'));
    array.emplace_back(std::move(row));
  }
  JsonObject of_rows;
  of_rows.emplace("rows", RowsOf(array, [](const JsonValue& row) { return row; }));
  of_rows.emplace("then", JsonArray{1, 2});
  JsonObject of_array;
  of_array.emplace("rows", array);
  of_array.emplace("then", JsonArray{1, 2});
  std::string text;
  std::size_t most = 0;
  const Status status = DumpJson(of_rows, "f", [&](std::string_view piece) {
    most = std::max(most, piece.size());
    text += piece;
    return Ok();
  });
  ASSERT_TRUE(status.ok()) << status.error().message;
  EXPECT_EQ(text, *DumpJson(std::move(of_array), "f"));
  EXPECT_LT(most, text.size() / 4);
}

TEST(JsonByPieces, EndsWhereItsSinkDoes) {
  std::size_t num_made = 0;
  JsonObject document;
  document.emplace("rows", JsonRows{100'000, [&](std::size_t) {
                                      ++num_made;
                                      return JsonValue(std::string(100, 'x'));
                                    }});
  int num_pieces = 0;
  const Status status = DumpJson(document, "f", [&](std::string_view) {
    return ++num_pieces < 2 ? Ok() : Status(Failed("full"));
  });
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().message, "full");
  EXPECT_EQ(num_pieces, 2);
  EXPECT_LT(num_made, 50'000u);
}

TEST(LinesByPieces, TrajectoriesAndEdgesAreReadAsTheWhole) {
  const Odometry odometry = SampleOdometry();
  const std::string g2o = *G2oText(odometry);
  const std::string tum = *EncodeTum(StampedPoses(odometry.frames), "f");
  const std::string fault = G2oEdges(g2o + "EDGE_SE3:QUAT 0 1\n", "f").error().message;
  for (const std::size_t size : kPieceSizes) {
    Odometry read = odometry;
    read.edges = *G2oEdges(InPieces(g2o, size), "f");
    EXPECT_EQ(*G2oText(read), g2o);
    EXPECT_EQ(*EncodeTum(*DecodeTum(InPieces(tum, size), "f"), "f"), tum);
    EXPECT_EQ(G2oEdges(InPieces(g2o + "EDGE_SE3:QUAT 0 1\n", size), "f").error().message, fault);
  }
  EXPECT_THAT(fault, HasSubstr(":" + std::to_string(1 + std::ranges::count(g2o, '\n')) + ":"))
      << "the line's number in the file";
}

}  // namespace
}  // namespace deepslam::artifact
