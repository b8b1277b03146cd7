// Tracking and fusion beside those of Open3D and OpenCV: the same frames of one capture, decoded
// beforehand, each library with its own defaults and its own threads.
//   DEEPSLAM_BENCH_CAPTURE=... [DEEPSLAM_BENCH_FRAMES=60] deepslam_peers_bench
//   --benchmark_repetitions=3
// Counters: items_per_second is frames per second; ate_mm is the error of the camera path against
// the capture's own poses (speed that loses its way is none).
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <open3d/camera/PinholeCameraIntrinsic.h>
#include <open3d/geometry/RGBDImage.h>
#include <open3d/geometry/TriangleMesh.h>
#include <open3d/pipelines/integration/ScalableTSDFVolume.h>
#include <open3d/pipelines/odometry/Odometry.h>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/rgbd/depth.hpp>

#include "bench_capture.h"
#include "deepslam/core/parallel.h"
#include "deepslam/core/progress.h"
#include "deepslam/dataset/memory_frame_source.h"
#include "deepslam/geometry/trajectory_error.h"
#include "deepslam/fuse/tsdf.h"
#include "deepslam/tracking/odometry.h"

namespace deepslam {
namespace {

constexpr int kDefaultFrames = 60;
constexpr int kThreads = 2;

// The first frames of the capture, with the poses that came with it.
struct Sequence {
  PinholeCamera camera;
  std::vector<Frame> frames;
  std::vector<std::optional<Pose3>> true_poses;
};

Result<Sequence> ReadSequence() {
  const Result<dataset::Capture> capture = bench::OpenNamedCapture();
  if (!capture.ok()) return capture.error();
  const char* const wanted = std::getenv("DEEPSLAM_BENCH_FRAMES");  // NOLINT(concurrency-mt-unsafe)
  const int count = wanted == nullptr ? kDefaultFrames : std::atoi(wanted);  // NOLINT(cert-err34-c)
  Sequence sequence;
  sequence.camera = capture->frames->camera();
  for (int n = 0; n < std::min(count, capture->frames->num_frames()); ++n) {
    Result<Frame> frame = capture->frames->Read(FrameIdx{n});
    if (!frame.ok()) return frame.error();
    sequence.frames.push_back(std::move(frame).value());
    sequence.true_poses.push_back(capture->frames->capture_world_from_camera(FrameIdx{n}));
  }
  return sequence;
}

void Report(benchmark::State& state, const Sequence& sequence, const std::vector<Pose3>& found) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(sequence.frames.size()));
  std::vector<TimedPose> estimate;
  std::vector<TimedPose> truth;
  for (std::size_t n = 0; n < found.size(); ++n) {
    estimate.push_back({sequence.frames[n].time_s, found[n]});
    if (sequence.true_poses[n])
      truth.push_back({sequence.frames[n].time_s, *sequence.true_poses[n]});
  }
  const auto error = ComputeTrajectoryError(estimate, truth, {});
  if (error.ok()) state.counters["ate_mm"] = 1000.0 * error->ate_m.rmse;
}

Result<std::vector<Pose3>> TrackOurs(const Sequence& sequence) {
  const dataset::MemoryFrameSource frames(sequence.camera, sequence.frames);
  SilentProgress progress;
  const Result<Odometry> odometry = tracking::EstimateOdometry(frames, {}, progress);
  if (!odometry.ok()) return odometry.error();
  std::vector<Pose3> poses;
  for (const TrackedFrame& frame : odometry->frames) poses.push_back(frame.world_from_camera);
  return poses;
}

Pose3 FromMatrix(const Eigen::Matrix4d& matrix) {
  return {Eigen::Quaterniond(Eigen::Matrix3d(matrix.topLeftCorner<3, 3>())).normalized(),
          matrix.topRightCorner<3, 1>()};
}

// Depth in metres as float; colour as bytes, or as the grey values that Open3D's odometry takes.
open3d::geometry::RGBDImage ToOpen3d(const Frame& frame, bool grey) {
  open3d::geometry::RGBDImage image;
  const int width = frame.depth_m.width();
  const int height = frame.depth_m.height();
  image.depth_.Prepare(width, height, 1, 4);
  std::memcpy(
      image.depth_.data_.data(), frame.depth_m.data(), sizeof(float) * frame.depth_m.size());
  open3d::geometry::Image colour;
  colour.Prepare(width, height, 3, 1);
  std::memcpy(colour.data_.data(), frame.colour.data(), sizeof(Rgb8) * frame.colour.size());
  if (grey) {
    image.color_ = *colour.CreateFloatImage();
  } else {
    image.color_ = colour;
  }
  return image;
}

// Depth beyond is no measurement, as for our own fusion.
void KeepNear(double max_depth_m, open3d::geometry::Image& depth) {
  for (int v = 0; v < depth.height_; ++v) {
    for (int u = 0; u < depth.width_; ++u) {
      float& z = *depth.PointerAt<float>(u, v);
      if (z > static_cast<float>(max_depth_m)) z = 0;
    }
  }
}

open3d::camera::PinholeCameraIntrinsic ToOpen3d(const PinholeCamera& camera) {
  return {camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy};
}

void TrackDeepslam(benchmark::State& state) {
  const Result<Sequence> sequence = ReadSequence();
  if (!sequence.ok()) return state.SkipWithError(sequence.error().message.c_str());
  const ThreadLimit limit(kThreads);
  std::vector<Pose3> poses;
  for (auto _ : state) {
    Result<std::vector<Pose3>> found = TrackOurs(*sequence);
    if (!found.ok()) return state.SkipWithError(found.error().message.c_str());
    poses = std::move(found).value();
  }
  Report(state, *sequence, poses);
}

// Frame to frame, colour and depth (hybrid term).
void TrackOpen3d(benchmark::State& state) {
  const Result<Sequence> sequence = ReadSequence();
  if (!sequence.ok()) return state.SkipWithError(sequence.error().message.c_str());
  const auto intrinsic = ToOpen3d(sequence->camera);
  std::vector<Pose3> poses;
  for (auto _ : state) {
    poses.assign(1, Pose3{});
    for (std::size_t n = 1; n < sequence->frames.size(); ++n) {
      const auto [found, previous_from_current, information] =
          open3d::pipelines::odometry::ComputeRGBDOdometry(ToOpen3d(sequence->frames[n], true),
                                                           ToOpen3d(sequence->frames[n - 1], true),
                                                           intrinsic);
      poses.push_back(found ? poses.back() * FromMatrix(previous_from_current) : poses.back());
    }
  }
  Report(state, *sequence, poses);
}

// Frame to frame, colour and depth (RgbdICPOdometry).
void TrackOpencv(benchmark::State& state) {
  const Result<Sequence> sequence = ReadSequence();
  if (!sequence.ok()) return state.SkipWithError(sequence.error().message.c_str());
  const PinholeCamera& camera = sequence->camera;
  const cv::Mat matrix =
      (cv::Mat_<double>(3, 3) << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  std::vector<Pose3> poses;
  for (auto _ : state) {
    const auto odometry = cv::rgbd::RgbdICPOdometry::create(matrix);
    const auto frame_of = [&](const Frame& frame) {
      const cv::Mat colour(
          camera.height,
          camera.width,
          CV_8UC3,
          const_cast<Rgb8*>(frame.colour.data()));  // NOLINT: cv::Mat has no const view
      cv::Mat grey;
      cv::cvtColor(colour, grey, cv::COLOR_RGB2GRAY);
      cv::Mat depth(camera.height, camera.width, CV_32FC1);
      for (int v = 0; v < camera.height; ++v) {
        for (int u = 0; u < camera.width; ++u) {
          const float z = frame.depth_m(u, v);
          depth.at<float>(v, u) = z > 0 ? z : std::numeric_limits<float>::quiet_NaN();
        }
      }
      return cv::makePtr<cv::rgbd::OdometryFrame>(grey, depth);
    };
    poses.assign(1, Pose3{});
    cv::Ptr<cv::rgbd::OdometryFrame> previous = frame_of(sequence->frames[0]);
    for (std::size_t n = 1; n < sequence->frames.size(); ++n) {
      cv::Ptr<cv::rgbd::OdometryFrame> current = frame_of(sequence->frames[n]);
      cv::Mat found;
      Eigen::Matrix4d previous_from_current = Eigen::Matrix4d::Identity();
      if (odometry->compute(current, previous, found) && !found.empty()) {
        cv::cv2eigen(found, previous_from_current);
      }
      poses.push_back(poses.back() * FromMatrix(previous_from_current));
      previous = current;
    }
  }
  Report(state, *sequence, poses);
}

// Poses for fusion: the capture's own, else those found by tracking.
Result<std::vector<Pose3>> PosesOf(const Sequence& sequence) {
  std::vector<Pose3> poses;
  for (const std::optional<Pose3>& pose : sequence.true_poses) {
    if (pose) poses.push_back(*pose);
  }
  if (poses.size() == sequence.frames.size()) return poses;
  return TrackOurs(sequence);
}

void FuseDeepslam(benchmark::State& state) {
  const Result<Sequence> sequence = ReadSequence();
  if (!sequence.ok()) return state.SkipWithError(sequence.error().message.c_str());
  const Result<std::vector<Pose3>> poses = PosesOf(*sequence);
  if (!poses.ok()) return state.SkipWithError(poses.error().message.c_str());
  const ThreadLimit limit(kThreads);
  std::size_t num_vertices = 0;
  for (auto _ : state) {
    fuse::TsdfFusion fusion({});
    for (std::size_t n = 0; n < sequence->frames.size(); ++n) {
      const Status status =
          fusion.Integrate(sequence->frames[n], sequence->camera, (*poses)[n], nullptr);
      if (!status.ok()) return state.SkipWithError(status.error().message.c_str());
    }
    num_vertices = fusion.ExtractMesh().vertices.size();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(sequence->frames.size()));
  state.counters["vertices"] = static_cast<double>(num_vertices);
}

void FuseOpen3d(benchmark::State& state) {
  const Result<Sequence> sequence = ReadSequence();
  if (!sequence.ok()) return state.SkipWithError(sequence.error().message.c_str());
  const Result<std::vector<Pose3>> poses = PosesOf(*sequence);
  if (!poses.ok()) return state.SkipWithError(poses.error().message.c_str());
  const auto intrinsic = ToOpen3d(sequence->camera);
  const fuse::FuseOptions options;
  std::size_t num_vertices = 0;
  for (auto _ : state) {
    open3d::pipelines::integration::ScalableTSDFVolume volume(
        options.voxel_m,
        options.truncation_m,
        open3d::pipelines::integration::TSDFVolumeColorType::RGB8);
    for (std::size_t n = 0; n < sequence->frames.size(); ++n) {
      open3d::geometry::RGBDImage image = ToOpen3d(sequence->frames[n], false);
      KeepNear(options.max_depth_m, image.depth_);
      volume.Integrate(image, intrinsic, (*poses)[n].Inverse().Matrix());
    }
    num_vertices = volume.ExtractTriangleMesh()->vertices_.size();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(sequence->frames.size()));
  state.counters["vertices"] = static_cast<double>(num_vertices);
}

BENCHMARK(TrackDeepslam)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(TrackOpen3d)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(TrackOpencv)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(FuseDeepslam)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(FuseOpen3d)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace deepslam
