// Image files of a capture with their times, and the two of a frame.
#pragma once

#include <string>

namespace deepslam::dataset {

struct TimedFile {
  double time_s = 0;
  std::string file;       // relative to the capture, never leaving it
  int line = 0;           // 1-based, of the list; 0: of none
  int clock_segment = 0;  // of the list's clock, 0-based
};

struct ImagePair {
  TimedFile colour;
  TimedFile depth;
};

inline int ClockSegmentOf(const TimedFile& file) { return file.clock_segment; }
inline int ClockSegmentOf(const ImagePair& pair) { return pair.depth.clock_segment; }

}  // namespace deepslam::dataset
