// The seam between room dataset, which reads videos, and the module libdeepslam_video.so, which
// decodes them and is loaded when one is opened: its libraries take longer to load than the program
// takes to start without them. Plain C functions, since the two are linked apart from each other.
#pragma once

namespace deepslam::video {

inline constexpr const char* kModuleFile = "libdeepslam_video.so";
inline constexpr const char* kModuleEntry = "deepslam_video_module";

struct Decoder;

struct VideoModule {
  int version = 0;  // kVersion of the header that the module was compiled with
  // Null: no video that can be decoded here.
  Decoder* (*open)(const char* file) = nullptr;
  void (*close)(Decoder* decoder) = nullptr;
  // Of the frames as stored, px: rotation tags are ignored.
  int (*width)(const Decoder* decoder) = nullptr;
  int (*height)(const Decoder* decoder) = nullptr;
  // How many frames the file's own index says it has; 0: it says nothing.
  int (*num_frames)(const Decoder* decoder) = nullptr;
  // Decodes the next frame into width x height x (red, green, blue), row by row without gaps; null:
  // it is passed over. False at the end of what can be decoded.
  bool (*next)(Decoder* decoder, unsigned char* rgb) = nullptr;

  static constexpr int kVersion = 2;  // rises with every change of this struct
};

using ModuleEntry = const VideoModule*();

}  // namespace deepslam::video

// What the module exports, by the name of kModuleEntry.
extern "C" const deepslam::video::VideoModule* deepslam_video_module();
