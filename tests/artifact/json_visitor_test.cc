// A struct that is described once is written and read by the same names.
#include "deepslam/artifact/json_visitor.h"

#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "support/text_in_pieces.h"

namespace deepslam::artifact {

enum class Wood { kOak, kPine };

struct Shelf {
  FrameIdx frame;
  double width_m = 0;
  std::vector<float> weights;
  friend bool operator==(const Shelf&, const Shelf&) = default;
};

struct Board {
  std::string name;
  Wood wood = Wood::kOak;
  bool is_painted = false;
  int num_nails = 0;
  std::optional<double> age_s;
  std::string note = "none";
  std::map<std::string, int> counts;
  std::vector<Shelf> shelves;
  friend bool operator==(const Board&, const Board&) = default;
};

void Describe(JsonVisitor& visitor, Wood& wood) {
  static constexpr std::array<std::string_view, 2> kNames = {"oak", "pine"};
  visitor.Choice(wood, kNames);
}

void Describe(JsonVisitor& visitor, Shelf& shelf) {
  visitor.Field("frame", shelf.frame);
  visitor.Field("width_m", shelf.width_m, Range{0, 5});
  visitor.Field("weights", shelf.weights, Range{-1, 1});
}

void Describe(JsonVisitor& visitor, Board& board) {
  visitor.Field("name", board.name);
  visitor.Field("wood", board.wood);
  visitor.Field("is_painted", board.is_painted);
  visitor.Field("num_nails", board.num_nails);
  visitor.Maybe("age_s", board.age_s, board.age_s.has_value());
  visitor.Maybe("note", board.note);
  visitor.Field("counts", board.counts);
  visitor.Table("shelves", board.shelves);
  visitor.WriteOnly("num_shelves", static_cast<int>(board.shelves.size()));
}

namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr JsonFormat kFormat{"deepslam/board", 3};

Board SampleBoard() {
  return {"left \"one\"",
          Wood::kPine,
          true,
          7,
          12.5,
          "",
          {{"bolts", 3}, {"pegs", 0}},
          {{FrameIdx{4}, 0.1, {0.1F, -1}}, {FrameIdx{}, 5, {}}}};
}

std::string TextOf(const Board& board) { return *EncodeDocument(kFormat, board, "board.json"); }

// The message of what became of the text with `from` replaced.
std::string FaultOf(const std::string& from, const std::string& to) {
  std::string text = TextOf(SampleBoard());
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  const Result<Board> read = DecodeDocument<Board>(kFormat, text, "board.json");
  return read.ok() ? "" : read.error().message;
}

TEST(JsonVisitor, ReadsEveryFieldThatItWrote) {
  for (const Board& board : {SampleBoard(), Board()}) {
    const std::string text = TextOf(board);
    for (const std::size_t size : {std::size_t{1}, std::size_t{7}, text.size()}) {
      const Result<Board> read =
          DecodeDocument<Board>(kFormat, testing_support::InPieces(text, size), "board.json");
      ASSERT_TRUE(read.ok()) << read.error().message;
      EXPECT_EQ(*read, board);
      EXPECT_EQ(TextOf(*read), text);
    }
  }
}

TEST(JsonVisitor, WritesWhatIsGivenAlone) {
  EXPECT_THAT(TextOf(SampleBoard()),
              AllOf(HasSubstr("\"age_s\": 12.5"), HasSubstr("\"num_shelves\": 2")));
  EXPECT_THAT(TextOf(Board()), AllOf(Not(HasSubstr("age_s")), HasSubstr("\"counts\": {}")));
}

TEST(JsonVisitor, LeavesValuesThatMayBeMissingAsTheyAre) {
  for (const char* const note : {"", "\"note\": null,"}) {
    std::string text = TextOf(Board());
    const std::string given = "\"note\": \"none\",";
    ASSERT_NE(text.find(given), std::string::npos);
    text.replace(text.find(given), given.size(), note);
    const Result<Board> read = DecodeDocument<Board>(kFormat, text, "board.json");
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->note, "none");
  }
}

TEST(JsonVisitor, FaultsNameFilePlaceAndValue) {
  EXPECT_THAT(FaultOf("\"width_m\": 0.1", "\"width_m\": 9.5"),
              AllOf(HasSubstr("board.json"),
                    HasSubstr("shelves[0].width_m"),
                    HasSubstr("9.5"),
                    HasSubstr("[0, 5]")));
  EXPECT_THAT(FaultOf("\"width_m\": 0.1", "\"breadth_m\": 0.1"),
              HasSubstr("shelves[0].width_m is missing"));
  EXPECT_THAT(FaultOf("-1]", "-2]"), HasSubstr("shelves[0].weights[1]"));
  EXPECT_THAT(FaultOf("\"frame\": 4", "\"frame\": -4"), HasSubstr("shelves[0].frame is -4"));
  EXPECT_THAT(FaultOf("\"num_nails\": 7", "\"num_nails\": 7.5"), HasSubstr("num_nails is 7.5"));
  EXPECT_THAT(FaultOf("\"pegs\": 0", "\"pegs\": true"), HasSubstr("counts.pegs"));
  EXPECT_THAT(FaultOf("\"pine\"", "\"ash\""), AllOf(HasSubstr("ash"), HasSubstr("oak, pine")));
  EXPECT_THAT(FaultOf("\"is_painted\": true", "\"is_painted\": 1"), HasSubstr("is_painted"));
}

}  // namespace
}  // namespace deepslam::artifact
