#include "deepslam/layouts/look_at_capture.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/dataset/doubts.h"
#include "deepslam/dataset/picture_alignment.h"
#include "deepslam/dataset/pose_readings.h"

namespace deepslam::layouts {
namespace {

constexpr int kNumDoubtedFrames = 5;  // whose depth is looked at: one may show but a wall
// More than the four that picture_alignment.cc asks for, as some have no edges.
constexpr int kNumAlignedFrames = 6;
// Pictures are looked at this wide: finer ones show texture, and take longer.
constexpr int kAlignedWidthPx = 320;
// Frames of a video are decoded from its beginning: only its first seconds are looked at.
constexpr int kFramesOfVideo = 60;
constexpr int kNumPosedFrames = 6;  // pairs for each of the gaps below
// Frames apart, of pairs that poses are held against: neighbours, and some that moved.
constexpr std::array<int, 5> kPoseGaps = {1, 2, 4, 10, 30};

// Some, of frames spread over the capture that can be read.
std::vector<DepthImage> DepthsAcross(const FrameSource& frames) {
  const int num_looks = std::min(kNumDoubtedFrames, frames.num_frames());
  std::vector<DepthImage> depths_m(static_cast<std::size_t>(num_looks));
  ParallelFor(depths_m.size(), [&](std::size_t n) {
    const FrameIdx idx{static_cast<int>(n) * (frames.num_frames() / num_looks)};
    Result<Frame> frame = frames.ReadDepth(idx);
    if (frame) depths_m[n] = std::move(frame->depth_m);
  });
  std::erase_if(depths_m, [](const DepthImage& depth_m) { return depth_m.empty(); });
  return depths_m;
}

// One pixel of each block, as colour is reduced.
DepthImage Thinned(const DepthImage& depth_m, int factor) {
  DepthImage thin(depth_m.width() / factor, depth_m.height() / factor);
  for (int v = 0; v < thin.height(); ++v) {
    for (int u = 0; u < thin.width(); ++u)
      thin(u, v) = depth_m(factor * u + factor / 2, factor * v + factor / 2);
  }
  return thin;
}

// Of the frames themselves, those that can be read.
std::vector<IntensityImage> PicturesOf(std::span<const dataset::PictureSample> samples) {
  std::vector<IntensityImage> pictures;
  for (const dataset::PictureSample& sample : samples) {
    if (!sample.pictures[0].empty()) pictures.push_back(sample.pictures[0]);
  }
  return pictures;
}

dataset::PictureSample SampleAt(const FrameSource& frames, int idx, int factor) {
  dataset::PictureSample sample;
  const Result<Frame> depth = frames.ReadDepth(FrameIdx{idx});
  if (!depth) return sample;
  sample.depth_m = Thinned(depth->depth_m, factor);
  for (std::size_t k = 0; k < dataset::kPictureOffsets.size(); ++k) {
    const int other = idx + dataset::kPictureOffsets[k];
    if (other < 0 || other >= frames.num_frames()) continue;
    Result<IntensityImage> picture = frames.ReadIntensity(FrameIdx{other}, factor);
    if (picture) sample.pictures[k] = *std::move(picture);
  }
  return sample;
}

std::vector<dataset::PictureSample> SamplesAcross(const FrameSource& frames, bool in_order) {
  const int num_frames =
      in_order ? std::min(kFramesOfVideo, frames.num_frames()) : frames.num_frames();
  const int num_looks = std::min(kNumAlignedFrames, num_frames);
  const int factor = std::clamp(frames.camera().width / kAlignedWidthPx, 1, 32);
  std::vector<dataset::PictureSample> samples(static_cast<std::size_t>(num_looks));
  ParallelFor(samples.size(), [&](std::size_t n) {
    const auto idx = static_cast<int>((2 * n + 1) * static_cast<std::size_t>(num_frames) /
                                      (2 * static_cast<std::size_t>(num_looks)));
    samples[n] = SampleAt(frames, idx, factor);
  });
  return samples;
}

// Pairs of frames with poses, by their gaps: each of a few across the capture with one behind it.
std::vector<std::pair<int, int>> PairsAcross(const std::vector<int>& posed) {
  std::set<std::pair<int, int>> pairs;
  const auto count = static_cast<int>(posed.size());
  for (const int gap : kPoseGaps) {
    if (gap >= count) continue;
    for (int n = 0; n < kNumPosedFrames; ++n) {
      const int first = (count - 1 - gap) * n / (kNumPosedFrames - 1);
      pairs.emplace(posed[static_cast<std::size_t>(first)],
                    posed[static_cast<std::size_t>(first + gap)]);
    }
  }
  return {pairs.begin(), pairs.end()};
}

std::map<int, DepthImage> DepthsOf(const FrameSource& frames,
                                   const std::vector<std::pair<int, int>>& pairs) {
  std::map<int, DepthImage> depths_m;
  for (const auto& [a, b] : pairs) depths_m[a] = depths_m[b] = DepthImage();
  std::vector<std::pair<const int, DepthImage>*> entries;
  for (auto& entry : depths_m) entries.push_back(&entry);
  ParallelFor(entries.size(), [&](std::size_t n) {
    Result<Frame> frame = frames.ReadDepth(FrameIdx{entries[n]->first});
    if (frame) entries[n]->second = std::move(frame->depth_m);
  });
  return depths_m;
}

}  // namespace

std::vector<std::string> DoubtsOf(const dataset::Capture& capture) {
  std::vector<std::string> doubts = dataset::CameraDoubts(capture.frames->camera());
  const auto add = [&](std::vector<std::string> more) {
    std::ranges::move(more, std::back_inserter(doubts));
  };
  if (capture.has_times) {
    std::vector<double> times_s;
    for (const dataset::StoredFrame& frame : capture.stored->frames())
      times_s.push_back(frame.depth_time_s);
    add(dataset::TimeDoubts(times_s));
  }
  add(dataset::DepthDoubts(DepthsAcross(*capture.frames)));
  const std::vector<dataset::PictureSample> samples =
      SamplesAcross(*capture.frames, capture.stored->colour_in_order());
  add(dataset::ColourDoubts(PicturesOf(samples)));
  add(dataset::AlignmentDoubts(samples));
  return doubts;
}

std::string FaultOfPoses(const dataset::Capture& capture, const std::string& poses_file) {
  const std::vector<dataset::StoredFrame>& stored = capture.stored->frames();
  std::vector<int> posed;
  for (std::size_t i = 0; i < stored.size(); ++i) {
    if (stored[i].world_from_colour) posed.push_back(static_cast<int>(i));
  }
  const std::vector<std::pair<int, int>> chosen = PairsAcross(posed);
  const std::map<int, DepthImage> depths_m = DepthsOf(*capture.frames, chosen);
  std::vector<dataset::PosedPair> pairs;
  for (const auto& [a, b] : chosen) {
    const DepthImage& a_m = depths_m.at(a);
    const DepthImage& b_m = depths_m.at(b);
    if (a_m.empty() || b_m.empty()) continue;
    pairs.push_back({&a_m,
                     &b_m,
                     *stored[static_cast<std::size_t>(a)].world_from_colour,
                     *stored[static_cast<std::size_t>(b)].world_from_colour});
  }
  const dataset::PoseFit fit = dataset::FitPoses(capture.frames->camera(), pairs);
  if (!fit.contradicts()) return {};
  return fmt::format(
      "{}: the poses contradict the depth: of points of one frame {:.0f} % lie on what another "
      "measured; read as {} it would be {:.0f} %. Write them as world from camera, camera axes x "
      "right, y down, z forward, in metres",
      poses_file,
      100 * fit.share,
      fit.best_reading,
      100 * fit.best_share);
}

}  // namespace deepslam::layouts
