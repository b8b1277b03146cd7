// Every codec: what was written reads back, to the last bit, and is the same bytes when written
// again; whatever is cut off, flipped, foreign or from the future is refused politely or still a
// sound value.
#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "artifact/sample_values.h"
#include "deepslam/artifact/association_json.h"
#include "deepslam/artifact/ground_json.h"
#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/loops_json.h"
#include "deepslam/artifact/objects_json.h"
#include "deepslam/artifact/ply.h"
#include "deepslam/artifact/pose_graph_g2o.h"
#include "deepslam/artifact/proposals_json.h"
#include "deepslam/artifact/registrations_json.h"
#include "deepslam/artifact/segments_json.h"
#include "deepslam/artifact/trajectory_files.h"

namespace deepslam::artifact {
namespace {

using testing::HasSubstr;
using namespace deepslam::testing_support;  // NOLINT(google-build-using-namespace)

// Decodes and encodes again: bytes, or the decoder's error.
using Recode = std::function<Result<std::string>(std::string_view)>;

struct CodecCase {
  std::string name;
  std::string encoded;
  Recode recode;
  bool versioned = true;  // JSON with format and version
  // A text of lines may be cut between two lines without notice; whole results are guarded by their
  // hashes.
  bool notices_cuts = true;
};

template <typename T, typename Text>
Recode MakeRecode(Result<T> (*decode)(Text, std::string_view),
                  std::function<Result<std::string>(const T&)> encode) {
  return [=](std::string_view text) -> Result<std::string> {
    const Result<T> value = decode(text, "file");
    if (!value.ok()) return value.error();
    return encode(*value);
  };
}

PlyMesh SamplePly() {
  PlyMesh ply;
  ply.mesh.vertices = {{0, 0, 0}, {1, 0, 0.1F}, {0, 1, 0}, {0, 0, 1e-7F}};
  ply.mesh.faces = {{0, 1, 2}, {0, 3, 1}};
  ply.mesh.colours = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {255, 0, 128}};
  ply.normals = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, -1}};
  ply.labels = {1, -1, 3, 4};
  return ply;
}

std::vector<CodecCase> Cases() {
  std::vector<CodecCase> cases;
  const Odometry odometry = SampleOdometry();
  const std::vector<StampedPose> poses = StampedPoses(odometry.frames);
  cases.push_back({"tum",
                   *EncodeTum(poses, "file"),
                   MakeRecode<std::vector<StampedPose>>(DecodeTum,
                                                        [](const std::vector<StampedPose>& value) {
                                                          return EncodeTum(value, "file");
                                                        }),
                   false,
                   false});
  cases.push_back(
      {"g2o",
       *G2oText(odometry),
       MakeRecode<std::vector<RelativePose>>(G2oEdges,
                                             [odometry](const std::vector<RelativePose>& edges) {
                                               Odometry same = odometry;
                                               same.edges = edges;
                                               return G2oText(same);
                                             }),
       false,
       false});
  const std::string tum = *EncodeTum(poses, "file");
  cases.push_back({"frames",
                   *FramesText(odometry),
                   [tum, odometry](std::string_view text) -> Result<std::string> {
                     const Result<Trajectory> table = DecodeTrajectory(text, tum, "file");
                     if (!table.ok()) return table.error();
                     return FramesText({*table, odometry.edges, nullptr});
                   }});
  const auto add = [&]<typename T>(std::string name,
                                   const T& value,
                                   Result<std::string> (*encode)(const T&, std::string_view),
                                   Result<T> (*decode)(TextSource, std::string_view)) {
    cases.push_back(
        {std::move(name), *encode(value, "file"), MakeRecode<T>(decode, [encode](const T& again) {
           return encode(again, "file");
         })});
  };
  add("doubts",
      std::vector<std::string>{"few fit", "\"half\" of them"},
      EncodeDoubts,
      DecodeDoubts);
  add("ground", SampleGround(), EncodeGround, DecodeGround);
  add("detections", SampleDetections(), EncodeDetections, DecodeDetections);
  add("tracks", SampleAssociation(), EncodeAssociation, DecodeAssociation);
  add("candidates", SampleProposals(), EncodeProposals, DecodeProposals);
  add("objects", SampleObjects(), EncodeObjectMap, DecodeObjectMap);
  add("loops", SampleLoops(), EncodeLoops, DecodeLoops);
  add("optimization", SampleOptimization(), EncodeOptimization, DecodeOptimization);
  add("map", SampleMap(), EncodeMap, DecodeMap);
  cases.push_back({"segments",
                   *SegmentsText(SampleSegments()),
                   MakeRecode<std::vector<Segment>>(DecodeSegments, SegmentsText)});
  cases.push_back({"registrations",
                   *EncodeRegistrations(SampleRegistrations(), "file"),
                   MakeRecode<std::vector<CandidateRegistration>>(
                       DecodeRegistrations, [](const std::vector<CandidateRegistration>& value) {
                         return EncodeRegistrations(value, "file");
                       })});
  cases.push_back({"ply",
                   *EncodePly(SamplePly(), "file"),
                   MakeRecode<PlyMesh>(
                       DecodePly, [](const PlyMesh& value) { return EncodePly(value, "file"); }),
                   false});
  return cases;
}

class CodecTest : public testing::TestWithParam<std::size_t> {
 protected:
  static const CodecCase& Case(std::size_t index) {
    static const std::vector<CodecCase> cases = Cases();
    return cases[index];
  }
};

TEST_P(CodecTest, WritesTheSameBytesAgainAfterReading) {
  const CodecCase& codec = Case(GetParam());
  const Result<std::string> again = codec.recode(codec.encoded);
  ASSERT_TRUE(again.ok()) << codec.name << ": " << again.error().message;
  EXPECT_EQ(*again, codec.encoded) << codec.name;
}

TEST_P(CodecTest, RefusesShortBuffers) {
  const CodecCase& codec = Case(GetParam());
  if (!codec.notices_cuts) {
    // Cut within a line: the last number or word is missing.
    const std::size_t cut = codec.encoded.find_last_of(' ');
    EXPECT_FALSE(codec.recode(codec.encoded.substr(0, cut)).ok()) << codec.name;
    return;
  }
  const std::size_t size = codec.encoded.size();
  for (const std::size_t keep :
       {std::size_t{0}, std::size_t{1}, size / 4, size / 2, size - size / 8, size - 3}) {
    const Result<std::string> cut = codec.recode(codec.encoded.substr(0, keep));
    ASSERT_FALSE(cut.ok()) << codec.name << " cut to " << keep << " of " << size;
    EXPECT_THAT(cut.error().message, HasSubstr("file")) << codec.name;
    EXPECT_EQ(cut.error().code, ErrorCode::kInvalidInput) << codec.name;
  }
}

TEST_P(CodecTest, SurvivesFlippedBytes) {
  const CodecCase& codec = Case(GetParam());
  const std::size_t step = std::max<std::size_t>(1, codec.encoded.size() / 400);
  int refused = 0;
  for (std::size_t at = 0; at < codec.encoded.size(); at += step) {
    for (const int flip : {0x01, 0x80}) {
      std::string damaged = codec.encoded;
      damaged[at] = static_cast<char>(damaged[at] ^ flip);
      // Another digit is another sound value; what is sound can be written.
      const Result<std::string> again = codec.recode(damaged);
      refused += again.ok() ? 0 : 1;
    }
  }
  EXPECT_GT(refused, 0) << codec.name;
}

TEST_P(CodecTest, RefusesTheFutureAndForeignDocuments) {
  const CodecCase& codec = Case(GetParam());
  if (!codec.versioned) {
    EXPECT_FALSE(codec.recode("solid cube\nfacet normal 0 0 1\n").ok()) << codec.name;
    return;
  }
  std::string future = codec.encoded;
  constexpr std::string_view kVersion = "\"version\": ";
  const std::size_t at = future.find(kVersion);
  ASSERT_NE(at, std::string::npos) << codec.name;
  future.insert(at + kVersion.size(), "9");
  const Result<std::string> from_future = codec.recode(future);
  ASSERT_FALSE(from_future.ok()) << codec.name;
  EXPECT_THAT(from_future.error().message, HasSubstr("use a newer deepslam"));
  for (const char* foreign :
       {"{}", "[]", "null", "{\"format\": \"glTF\", \"version\": 1}", "\xff\xfe", "42"}) {
    EXPECT_FALSE(codec.recode(foreign).ok()) << codec.name << " read " << foreign;
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         CodecTest,
                         testing::Range(std::size_t{0}, Cases().size()),
                         [](const testing::TestParamInfo<std::size_t>& param) {
                           return Cases()[param.param].name;
                         });

TEST(Codecs, KeepEveryFieldOfAnObject) {
  const ObjectMap map = SampleObjects();
  const Result<ObjectMap> read = DecodeObjectMap(*EncodeObjectMap(map, "f"), "f");
  ASSERT_TRUE(read.ok());
  const MapObject& a = map.objects[0];
  const MapObject& b = read->objects[0];
  EXPECT_EQ(a.world_from_object, b.world_from_object);
  EXPECT_EQ(a.scale_m, b.scale_m);
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.views[0].information, b.views[0].information);
  EXPECT_EQ(a.views[0].yaw_free, b.views[0].yaw_free);
  EXPECT_EQ(a.scores[0].views[0].num_seen, b.scores[0].views[0].num_seen);
  EXPECT_EQ(a.history[1].candidate, b.history[1].candidate);
  EXPECT_EQ(a.scores[0].seen_share, b.scores[0].seen_share);
  EXPECT_EQ(a.merged, b.merged);
  EXPECT_EQ(map.dropped, read->dropped);
}

TEST(Codecs, KeepOdometryToTheLastBit) {
  const Odometry odometry = SampleOdometry();
  const std::string frames = *FramesText(odometry);
  const std::string tum = *EncodeTum(StampedPoses(odometry.frames), "f");
  const std::string g2o = *G2oText(odometry);
  const Result<Odometry> read = OdometryOf({frames, tum, g2o, "f", "f"});
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->frames.size(), odometry.frames.size());
  for (std::size_t i = 0; i < odometry.frames.size(); ++i) {
    EXPECT_EQ(read->frames[i].world_from_camera, odometry.frames[i].world_from_camera);
    EXPECT_EQ(read->frames[i].time_s, odometry.frames[i].time_s);
    EXPECT_EQ(read->frames[i].status, odometry.frames[i].status);
    EXPECT_EQ(read->frames[i].keyframe, odometry.frames[i].keyframe);
  }
  EXPECT_EQ(read->keyframes, odometry.keyframes);
  for (std::size_t e = 0; e < odometry.edges.size(); ++e) {
    EXPECT_EQ(read->edges[e].i_from_j, odometry.edges[e].i_from_j);
    EXPECT_EQ(read->edges[e].information, odometry.edges[e].information);
    EXPECT_EQ(read->edges[e].composed, odometry.edges[e].composed);
  }
}

TEST(Codecs, RefuseEdgesOfFramesThatAreNotThere) {
  const Odometry odometry = SampleOdometry();
  const std::string frames = *FramesText(odometry);
  const std::string tum = *EncodeTum(StampedPoses(odometry.frames), "f");
  Odometry beyond = odometry;
  beyond.edges[1].j = FrameIdx{5};
  const std::string g2o = *G2oText(beyond);
  const auto line = 1 + std::ranges::count(g2o.substr(0, g2o.rfind("EDGE")), '\n');
  const Result<Odometry> read = OdometryOf({frames, tum, g2o, "frames.json", "odometry.g2o"});
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(
      read.error().message,
      "odometry.g2o:" + std::to_string(line) + ": joins frames 2 and 5 of the 5 of frames.json");
}

TEST(PoseGraphG2o, EndsWhereTheTakerDoes) {
  const std::string g2o = *G2oText(SampleOdometry());
  int num_taken = 0;
  const Status status = DecodeG2oEdges(g2o, "f", [&](const RelativePose&) {
    ++num_taken;
    return Status(Failed("full"));
  });
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(num_taken, 1);
}

TEST(PoseGraphG2o, EndsWhereItsSinkDoes) {
  Odometry odometry = SampleOdometry();
  odometry.edges.resize(5000, odometry.edges.front());
  int num_pieces = 0;
  const Status status = EncodeG2o(odometry, "f", [&](std::string_view piece) {
    EXPECT_LT(piece.size(), std::size_t{1} << 20) << "some edges, not all of them";
    return ++num_pieces < 2 ? Ok() : Status(Failed("full"));
  });
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().message, "full");
  EXPECT_EQ(num_pieces, 2);
}

// The file's chi^2 by g2o's convention (translation; quaternion vector part) is the program's r^T
// Omega r on t2v.
TEST(PoseGraphG2o, MeansTheSameErrorByG2osConvention) {
  Random random(7);
  Odometry odometry = SampleOdometry();
  const RelativePose& edge = odometry.edges[0];
  const Pose3 error = V2t((Vector6d() << 1e-3, -2e-3, 1e-3, 2e-3, 1e-3, -1e-3).finished());
  const Vector6d own = T2v(error);
  const double chi2 = own.dot(edge.information.Full() * own);

  const std::string text = *G2oText(odometry);
  const std::size_t begin = text.find("EDGE_SE3:QUAT 0 2");
  std::vector<double> numbers;
  std::istringstream line(text.substr(begin + 17, text.find('\n', begin) - begin - 17));
  for (double number = 0; line >> number;) numbers.push_back(number);
  ASSERT_EQ(numbers.size(), 28U);
  Matrix6d file_information;
  std::size_t at = 7;
  for (int row = 0; row < 6; ++row) {
    for (int col = row; col < 6; ++col)
      file_information(row, col) = file_information(col, row) = numbers[at++];
  }
  Vector6d g2o_error;
  g2o_error << error.translation_m, error.rotation.vec();
  // Half the rotation vector and the quaternion's vector part differ by a relative angle^2 / 24
  // here: 2e-7.
  EXPECT_NEAR(g2o_error.dot(file_information * g2o_error) / chi2, 1.0, 1e-5);
}

TEST(Json, RefusesNumbersThatAreNotFinite) {
  ObjectMap map = SampleObjects();
  map.objects[0].scale_m = std::nan("");
  const Result<std::string> text = EncodeObjectMap(map, "objects.json");
  ASSERT_FALSE(text.ok());
  EXPECT_THAT(text.error().message,
              testing::AllOf(HasSubstr("objects.json"), HasSubstr("objects[0].scale_m")));
}

TEST(Json, MinusZeroIsWrittenAsItIsReadAgain) {
  for (const char* const text : {"[-0.0]", "[-0]", "[0]", "[-1e-400]"}) {
    const std::string once = *DumpJson(*ParseJson(text, "f"), "f");
    EXPECT_EQ(*DumpJson(*ParseJson(once, "f"), "f"), once) << text;
  }
}

TEST(Json, RefusesDeepNesting) {
  EXPECT_FALSE(ParseJson(std::string(100'000, '[') + std::string(100'000, ']'), "deep.json").ok());
}

JsonObject Numbered(std::size_t k) {
  JsonObject row;
  row.emplace("number", static_cast<std::int64_t>(k));
  if (k % 3 == 0) row.emplace("long", std::string(150, 'x'));
  return row;
}

TEST(Json, RowsAreWrittenAsTheArrayOfThemIs) {
  for (const std::size_t count : {0, 1, 3, 200}) {
    JsonArray array;
    for (std::size_t k = 0; k < count; ++k) array.emplace_back(Numbered(k));
    JsonObject of_array = NewDocument("f", 1);
    of_array.emplace("rows", std::move(array));
    JsonObject of_rows = NewDocument("f", 1);
    of_rows.emplace("rows", JsonRows{count, Numbered});
    EXPECT_EQ(*DumpJson(std::move(of_rows), "f"), *DumpJson(std::move(of_array), "f")) << count;
  }
  JsonObject broken;
  broken.emplace("rows", JsonRows{9, [](std::size_t k) { return JsonValue(k < 7 ? 1.0 : NAN); }});
  EXPECT_THAT(DumpJson(std::move(broken), "f").error().message, HasSubstr("rows[7]"));
}

TEST(Json, TablesAreReadRowByRow) {
  constexpr int kRows = 200;
  JsonObject document = NewDocument("f", 1);
  document.emplace("rows", JsonRows{kRows, Numbered});
  document.emplace("whole", JsonArray{1, 2});
  const std::string text = *DumpJson(std::move(document), "f");
  std::vector<int> numbers;
  std::size_t most_at_once = 0;
  const auto read = [&](std::span<const JsonNode> rows) {
    most_at_once = std::max(most_at_once, rows.size());
    for (const JsonNode& row : rows) numbers.push_back(row["number"].Int(0, kRows));
  };
  JsonReader reader(text, "f", "f", 1, {{"rows", read}});
  EXPECT_TRUE(reader.ok());
  ASSERT_EQ(numbers.size(), static_cast<std::size_t>(kRows));
  for (int k = 0; k < kRows; ++k) EXPECT_EQ(numbers[static_cast<std::size_t>(k)], k);
  EXPECT_LT(most_at_once, 100u);
  EXPECT_TRUE(reader.root()["rows"].Items().empty()) << "rows stay with nobody";
  EXPECT_EQ(reader.root()["whole"].Items().size(), 2u);
}

TEST(Json, ATableMustBeThereOnceAndBeOne) {
  const auto fault = [](const std::string& members, int version = 1) {
    const auto read = [](std::span<const JsonNode> rows) {
      for (const JsonNode& row : rows) static_cast<void>(row["number"].Int(0, 9));
    };
    const std::string text = "{\"format\": \"f\", \"version\": 1" + members + "}";
    return JsonReader(text, "file", "f", version, {{"rows", read}}).error().message;
  };
  EXPECT_EQ(fault(R"(, "rows": [{"number": 3}])"), "");
  EXPECT_THAT(fault(""), HasSubstr("rows is missing"));
  EXPECT_THAT(fault(R"(, "rows": {})"), HasSubstr("rows must be an array"));
  EXPECT_THAT(fault(R"(, "rows": 3)"), HasSubstr("rows must be an array"));
  EXPECT_THAT(fault(R"(, "rows": [], "rows": [])"), HasSubstr("holds \"rows\" twice"));
  EXPECT_THAT(fault(R"(, "rows": [{"number": 3}, {"number": 12}, {}])"),
              HasSubstr("rows[1].number is 12"));
  EXPECT_THAT(fault(R"(, "rows": [{"number": 12}])", 2), HasSubstr("version is 1"))
      << "what is wrong with the rows says less";
  EXPECT_EQ(fault(R"(, "rows": [{"number": 1}], "more": {"rows": [{}], "deep": [[{}]]})"), "")
      << "a member of that name further down is none";
}

std::vector<Segment> ManySegments() {
  std::vector<Segment> segments(150);
  for (std::size_t k = 0; k < segments.size(); ++k) {
    Segment& segment = segments[k];
    segment.detection = DetectionId{static_cast<int>(k)};
    segment.frame = FrameIdx{static_cast<int>(k / 2)};
    segment.class_name = "chair";
    if (k % 5 == 0) continue;  // without a mask
    Mask mask(40, 30);
    mask(static_cast<int>(k % 40), static_cast<int>(k % 30)) = 1;
    segment.mask = mask;
  }
  return segments;
}

TEST(Segments, KeepTheirMasksHoweverMany) {
  const std::vector<Segment> segments = ManySegments();
  const Result<std::vector<Segment>> read = DecodeSegments(*SegmentsText(segments), "f");
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->size(), segments.size());
  for (std::size_t k = 0; k < segments.size(); ++k) {
    EXPECT_EQ((*read)[k].detection, segments[k].detection);
    EXPECT_EQ((*read)[k].mask, segments[k].mask) << k;
  }
}

TEST(Segments, AreReadWithoutMasksOrInPart) {
  std::vector<Segment> segments = ManySegments();
  const std::string text = *SegmentsText(segments);
  const Result<std::vector<Segment>> some =
      DecodeSegmentsOf({DetectionId{3}, DetectionId{77}, DetectionId{4000}}, text, "f");
  ASSERT_TRUE(some.ok()) << some.error().message;
  EXPECT_EQ(*SegmentsText(*some), *SegmentsText({segments[3], segments[77]}));
  const Result<std::vector<Segment>> bare = DecodeSegmentsWithoutMasks(text, "f");
  ASSERT_TRUE(bare.ok()) << bare.error().message;
  for (Segment& segment : segments) segment.mask = {};
  EXPECT_EQ(*SegmentsText(*bare), *SegmentsText(segments));
}

TEST(GroundJson, HoldsWhatTheUserSaysOfThePicturesIfAnything) {
  Ground ground = SampleGround();
  const std::string silent = *EncodeGround(ground, "f");
  EXPECT_THAT(silent, testing::Not(HasSubstr("upright")));
  EXPECT_FALSE(DecodeGround(silent, "f")->upright.has_value());
  for (const QuarterTurn said : {QuarterTurn::kNone,
                                 QuarterTurn::kClockwise,
                                 QuarterTurn::kHalf,
                                 QuarterTurn::kAnticlockwise}) {
    ground.upright = said;
    EXPECT_EQ(DecodeGround(*EncodeGround(ground, "f"), "f")->upright, said);
  }
  std::string text = *EncodeGround(ground, "f");
  text.replace(text.find("270"), 3, "100");
  const Result<Ground> read = DecodeGround(text, "ground/ground.json");
  ASSERT_FALSE(read.ok());
  EXPECT_THAT(read.error().message,
              testing::AllOf(HasSubstr("ground/ground.json"), HasSubstr("upright_deg")));
}

TEST(Json, FaultNamesPlaceAndValue) {
  std::string text = *EncodeDetections(SampleDetections(), "f");
  const std::size_t at = text.find("\"score\": 0.75");
  text.replace(at, 13, "\"score\": 1.75");
  const Result<DetectionTable> read = DecodeDetections(text, "detect/detections.json");
  ASSERT_FALSE(read.ok());
  EXPECT_THAT(read.error().message,
              testing::AllOf(HasSubstr("detect/detections.json"),
                             HasSubstr("annotations[0].score"),
                             HasSubstr("1.75")));
}

TEST(Proposals, RefuseModelKeysThatLeaveTheFolder) {
  for (const char* key : {"../x", "a/b", "", ".hidden", "a b", "x\\y"})
    EXPECT_FALSE(IsModelKey(key)) << key;
  EXPECT_TRUE(IsModelKey("Scopia-chair_3.2"));
}

TEST(Proposals, TellWhereAShapeWasMeasuredWhollyOrNotAtAll) {
  const std::string text = *EncodeProposals(SampleProposals(), "f");
  const auto without = [&](std::string_view key) {
    std::string changed = text;
    const std::size_t at = changed.find(key);
    EXPECT_NE(at, std::string::npos) << key;
    return changed.replace(at + 1, 1, "_");
  };
  for (const std::string_view key : {"\"scale_m\"", "\"world_from_object\""}) {
    const Result<Proposals> read = DecodeProposals(without(key), "propose/candidates.json");
    ASSERT_FALSE(read.ok()) << key;
    EXPECT_THAT(read.error().message, HasSubstr("candidates[0]"));
  }
  std::string flat = text;
  flat.replace(flat.find("\"scale_m\": 0.9"), 14, "\"scale_m\": 0.0");
  EXPECT_FALSE(DecodeProposals(flat, "f").ok());
}

TEST(Tum, FaultNamesTheLine) {
  const Result<std::vector<StampedPose>> read =
      DecodeTum("# c\n0 0 0 0 0 0 0 1\n1 0 0 x 0 0 0 1\n", "t.tum");
  ASSERT_FALSE(read.ok());
  EXPECT_THAT(read.error().message, testing::AllOf(HasSubstr("t.tum:3"), HasSubstr("\"x\"")));
}

TEST(Ply, RefusesCountsTheBytesCannotHold) {
  std::string bytes = *EncodePly(SamplePly(), "f");
  const std::size_t at = bytes.find("element vertex 4");
  bytes.replace(at, 16, "element vertex 200000000");
  EXPECT_FALSE(DecodePly(bytes, "f").ok());
}

TEST(DetectionsJson, TellsFramesWithoutPeopleFromFramesNobodyLookedAt) {
  DetectionTable table = SampleDetections();
  table.images[0].contains_person = true;
  table.images[1].contains_person = false;
  EXPECT_EQ(DecodeDetections(*EncodeDetections(table, "f"), "f")->images, table.images);
  EXPECT_FALSE(DecodeDetections(*EncodeDetections(SampleDetections(), "f"), "f")
                   ->images[0]
                   .contains_person.has_value());
}

}  // namespace
}  // namespace deepslam::artifact
