// Lists of captures for `deepslam batch`.
#include "deepslam/batch/capture_list.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(batch_list) {
  // Patterns would be looked up on this machine's disk.
  if (bytes.find_first_of("*?[") != std::string_view::npos) return false;
  const auto captures = batch::ReadCaptureList(bytes, kFile, "/nowhere");
  if (!captures.ok()) return Refused(captures.error());
  const Status status = batch::CheckNames(*captures);
  if (!status.ok()) return Refused(status.error());
  for (const batch::ListedCapture& capture : *captures) {
    DEEPSLAM_CHECK(!capture.name.empty() && capture.name.find('/') == std::string::npos &&
                       capture.name.front() != '.' && capture.name.front() != '-',
                   "a workspace's name stays in its folder");
    DEEPSLAM_CHECK(capture.path.is_absolute(), "a capture's path is whole");
  }
  return true;
}
