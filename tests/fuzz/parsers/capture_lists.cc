// rgb.txt, depth.txt, associations.txt and groundtruth.txt of the TUM layout.
#include <filesystem>
#include <string>
#include <vector>

#include "deepslam/formats/tum_lists.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(capture_lists) {
  const std::string text(bytes);
  const std::filesystem::path file(kFile);
  std::vector<std::string> warnings;
  bool accepted = false;
  if (const auto files = formats::ParseFileList(text, file, warnings); files.ok()) {
    accepted = true;
    for (const dataset::TimedFile& listed : *files)
      DEEPSLAM_CHECK(StaysBelow(listed.file), "an image lies below the capture");
    for (const dataset::ImagePair& pair : formats::AssociateByTime(*files, *files, 0.02))
      DEEPSLAM_CHECK(pair.colour.time_s == pair.depth.time_s, "each is its own nearest");
  } else {
    Refused(files.error());
  }
  if (const auto pairs = formats::ParseAssociations(text, file, warnings); pairs.ok()) {
    accepted = true;
    for (const dataset::ImagePair& pair : *pairs) {
      DEEPSLAM_CHECK(StaysBelow(pair.colour.file) && StaysBelow(pair.depth.file),
                     "an image lies below the capture");
    }
  } else {
    Refused(pairs.error());
  }
  if (const auto poses = formats::ParsePoses(text, file, warnings); poses.ok()) {
    accepted = accepted || !poses->empty();
    for (const formats::TimedPose& pose : *poses) {
      const auto segment = ClockSegment(*poses, pose.clock_segment);
      DEEPSLAM_CHECK(formats::PoseAt(segment, pose.time_s, 0, 0).has_value(),
                     "a pose at its own time");
      const auto beside = formats::PoseAt(segment, pose.time_s + 0.01, 0.02, 1);
      DEEPSLAM_CHECK(!beside || beside->translation_m.allFinite(), "poses are finite");
    }
  } else {
    Refused(poses.error());
  }
  return accepted;
}
