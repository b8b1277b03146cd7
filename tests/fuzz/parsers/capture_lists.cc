// rgb.txt, depth.txt, associations.txt and groundtruth.txt of the TUM layout.
#include <filesystem>
#include <string>
#include <vector>

#include "deepslam/dataset/tum_lists.h"
#include "fuzz/entry.h"

namespace deepslam::fuzz {
namespace {

void CheckInside(const dataset::TimedFile& file) {
  const std::filesystem::path path(file.file);
  DEEPSLAM_CHECK(path.is_relative(), "an image lies below the capture");
  for (const std::filesystem::path& part : path)
    DEEPSLAM_CHECK(part != "..", "an image lies below the capture");
}

}  // namespace
}  // namespace deepslam::fuzz

DEEPSLAM_FUZZ(capture_lists) {
  const std::string text(bytes);
  const std::filesystem::path file(kFile);
  std::vector<std::string> warnings;
  bool accepted = false;
  if (const auto files = dataset::ParseFileList(text, file, warnings); files.ok()) {
    accepted = true;
    for (const dataset::TimedFile& listed : *files) CheckInside(listed);
    for (const dataset::ImagePair& pair : dataset::AssociateByTime(*files, *files, 0.02))
      DEEPSLAM_CHECK(pair.colour.time_s == pair.depth.time_s, "each is its own nearest");
  } else {
    Refused(files.error());
  }
  if (const auto pairs = dataset::ParseAssociations(text, file, warnings); pairs.ok()) {
    accepted = true;
    for (const dataset::ImagePair& pair : *pairs) {
      CheckInside(pair.colour);
      CheckInside(pair.depth);
    }
  } else {
    Refused(pairs.error());
  }
  if (const auto poses = dataset::ParsePoses(text, file, warnings); poses.ok()) {
    accepted = accepted || !poses->empty();
    for (const dataset::TimedPose& pose : *poses) {
      DEEPSLAM_CHECK(dataset::PoseAt(*poses, pose.time_s, 0, 0).has_value(),
                     "a pose at its own time");
      const auto beside = dataset::PoseAt(*poses, pose.time_s + 0.01, 0.02, 1);
      DEEPSLAM_CHECK(!beside || beside->translation_m.allFinite(), "poses are finite");
    }
  } else {
    Refused(poses.error());
  }
  return accepted;
}
