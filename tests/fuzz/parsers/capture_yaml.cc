// capture.yaml.
#include <string>

#include "deepslam/dataset/capture_settings.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(capture_yaml) {
  const Result<dataset::CaptureSettings> read =
      dataset::ParseCaptureSettings(std::string(bytes), kFile);
  if (!read.ok()) return Refused(read.error());
  if (const Status complete = dataset::RequireComplete(*read, kFile); !complete.ok())
    Refused(complete.error());
  const std::string text = dataset::FormatCaptureSettings(*read);
  const Result<dataset::CaptureSettings> again = dataset::ParseCaptureSettings(text, kFile);
  DEEPSLAM_CHECK(again.ok(), "what was written can be read");
  DEEPSLAM_CHECK(again->warnings.empty(), "what was written is all known");
  // A unit quaternion is normalised anew with each reading: its last digit may change.
  if (!read->colour_from_depth)
    DEEPSLAM_CHECK(dataset::FormatCaptureSettings(*again) == text, "reading changes nothing");
  return true;
}
