// TUM trajectories.
#include "deepslam/artifact/trajectory_files.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(trajectory) {
  const auto poses = artifact::DecodeTum(bytes, kFile);
  if (!poses.ok()) return Refused(poses.error());
  const Result<std::string> text = artifact::EncodeTum(*poses, kFile);
  DEEPSLAM_CHECK(text.ok(), "what was read can be written");
  const auto again = artifact::DecodeTum(*text, kFile);
  DEEPSLAM_CHECK(again.ok() && again->size() == poses->size(), "what was written can be read");
  return !poses->empty();
}
