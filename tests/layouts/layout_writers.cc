#include "layout_writers.h"

#include <cmath>
#include <cstdint>
#include <cstring>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include "foreign_captures.h"

namespace deepslam::layouts::foreign {
namespace {

namespace fs = std::filesystem;
using testing_support::WriteText;

const std::string kMatrix3 = "30.3 0 15.5\n0 30.3 11.25\n0 0 1\n";
const std::string kMatrix4 = "30.3 0 15.5 0\n0 30.3 11.25 0\n0 0 1 0\n0 0 0 1\n";
const std::string kIdentityRows = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";

std::array<double, 16> OpenGl(int i) {
  std::array<double, 16> m = Matrix(i);
  for (const std::size_t row : {0U, 4U, 8U}) {
    m[row + 1] = -m[row + 1];
    m[row + 2] = -m[row + 2];
  }
  return m;
}

// x y z and a quaternion of the pose turned half about x: (q of y by a) * (1, 0, 0; 0).
struct OpenGlQuaternion {
  double x, y, z, w;
};
OpenGlQuaternion OpenGlTurn(int i) {
  const double half = 0.05 * i;
  return {std::cos(half), 0, -std::sin(half), 0};
}

void WriteFrameFiles(const fs::path& folder, bool pgm) {
  for (int i = 0; i < kWrittenFrames; ++i) {
    const std::string stem = "frame-" + Digits(i, 6);
    WriteText(folder / (stem + ".color.png"), ColourFile(i));
    if (pgm) WriteText(folder / (stem + ".depth.pgm"), PgmDepth(i));
    if (!pgm) WriteText(folder / (stem + ".depth.png"), DepthFile(i));
    WriteText(folder / (stem + ".pose.txt"), MatrixText(Matrix(i)));
  }
}

void WriteThreeDMatch(const fs::path& folder) {
  WriteFrameFiles(folder, false);
  WriteText(folder / "camera-intrinsics.txt", kMatrix3);
}

std::string Info() {
  const std::string k = "30.3 0 15.5 0 0 30.3 11.25 0 0 0 1 0 0 0 0 1";
  const std::string one = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";
  return "m_versionNumber = 4\nm_sensorName = StructureSensor\nm_colorWidth = 32\nm_colorHeight = "
         "24\nm_depthWidth = 32\nm_depthHeight = 24\nm_depthShift = "
         "1000\nm_calibrationColorIntrinsic = " +
         k + "\nm_calibrationColorExtrinsic = " + one + "\nm_calibrationDepthIntrinsic = " + k +
         "\nm_calibrationDepthExtrinsic = " + one + "\nm_frames.size = 4\n";
}

void WriteBundleFusion(const fs::path& folder) {
  WriteFrameFiles(folder, false);
  WriteText(folder / "info.txt", Info());
}

void WriteThreeRScan(const fs::path& folder) {
  WriteFrameFiles(folder, true);
  WriteText(folder / "_info.txt", Info());
}

void WriteScanNetExport(const fs::path& folder) {
  for (int i = 0; i < kWrittenFrames; ++i) {
    WriteText(folder / fmt::format("color/{}.png", i), ColourFile(i));
    WriteText(folder / fmt::format("depth/{}.png", i), DepthFile(i));
    WriteText(folder / fmt::format("pose/{}.txt", i), MatrixText(Matrix(i)));
  }
  for (const char* camera : {"color", "depth"}) {
    WriteText(folder / fmt::format("intrinsic/intrinsic_{}.txt", camera), kMatrix4);
    WriteText(folder / fmt::format("intrinsic/extrinsic_{}.txt", camera), kIdentityRows);
  }
}

void WriteSun3d(const fs::path& folder) {
  std::string poses;
  for (int i = 0; i < kWrittenFrames; ++i) {
    cv::Mat raw(kHeight, kWidth, CV_16UC1);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const std::uint32_t mm = DepthMm(i, u, v);
        raw.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(mm << 3U | mm >> 13U);
      }
    }
    const std::string name = fmt::format("{:07d}-{:012d}", i + 1, 100000 * i);
    WriteText(folder / "image" / (name + ".png"), ColourFile(i));
    WriteText(folder / "depth" / (name + ".png"), Encoded(".png", raw));
    const std::string rows = MatrixText(Matrix(i));
    poses += rows.substr(0, rows.rfind('\n', rows.size() - 2) + 1);
  }
  WriteText(folder / "intrinsics.txt", kMatrix3);
  WriteText(folder / "extrinsics/20140101000000.txt", kIdentityRows);
  WriteText(folder / "extrinsics/20140808220511.txt", poses);
}

void WriteReplica(const fs::path& folder) {
  std::string poses;
  for (int i = 0; i < kWrittenFrames; ++i) {
    WriteText(folder / fmt::format("results/frame{:06d}.png", i), ColourFile(i));
    WriteText(folder / fmt::format("results/depth{:06d}.png", i), DepthFile(i));
    std::string matrix = MatrixText(Matrix(i));
    for (char& c : matrix) c = c == '\n' || c == '\t' ? ' ' : c;
    poses += matrix + "\n";
  }
  WriteText(folder / "traj.txt", poses);
  WriteText(folder / "cam_params.json",
            R"({"camera": {"w": 32, "h": 24, "fx": 30.3, "fy": 30.3, "cx": 15.5, "cy": 11.25,
                           "scale": 1000}})");
}

void WriteHabitat(const fs::path& folder) {
  std::string poses;
  for (int i = 0; i < kWrittenFrames; ++i) {
    WriteText(folder / fmt::format("rgb/{}.png", i + 1), ColourFile(i));
    WriteText(folder / fmt::format("depth/{}.png", i + 1), DepthFile(i));
    const OpenGlQuaternion q = OpenGlTurn(i);
    poses += fmt::format("{} 1.25 -2 {} {} {} {}\n", 0.5 * i, q.w, q.x, q.y, q.z);
  }
  WriteText(folder / "GT_Pose.txt", poses);
  WriteText(folder / "capture.yaml",
            "camera: {width: 32, height: 24, fx: 30.3, fy: 30.3, cx: 15.5, cy: "
            "11.25}\ndepth_units_per_m: 1000\n");
}

void WriteFolders(const fs::path& folder) {
  std::string poses;
  for (int i = 0; i < kWrittenFrames; ++i) {
    WriteText(folder / fmt::format("colour/{}.png", i + 1), ColourFile(i));
    WriteText(folder / fmt::format("depth/{}.pgm", i + 1), PgmDepth(i));
    poses += Tum(i) + "\n";
  }
  WriteText(folder / "pose.txt", poses);
  WriteText(folder / "K.txt", kMatrix3);
  WriteText(folder / "capture.yaml", "depth_units_per_m: 1000\n");
}

void WriteRecord3d(const fs::path& folder) {
  std::string poses;
  for (int i = 0; i < kWrittenFrames; ++i) {
    WriteText(folder / fmt::format("rgb/{}.png", i), ColourFile(i));
    WriteText(folder / fmt::format("depth/{}.exr", i), ExrDepth(i));
    const cv::Mat sure(kHeight, kWidth, CV_8UC1, cv::Scalar(2));
    WriteText(folder / fmt::format("confidence/{}.png", i), Encoded(".png", sure));
    const OpenGlQuaternion q = OpenGlTurn(i);
    poses += fmt::format(
        "{}[{}, {}, {}, {}, {}, 1.25, -2]", i == 0 ? "" : ", ", q.x, q.y, q.z, q.w, 0.5 * i);
  }
  WriteText(folder / "metadata.json",
            R"({"w": 32, "h": 24, "dw": 32, "dh": 24, "fps": 10, "initPose": [0, 0, 0, 1, 0, 0, 0],
                "K": [30.3, 0, 0, 0, 30.3, 0, 15.5, 11.25, 1], "poses": [)" +
                poses + "]}");
}

void WritePolycam(const fs::path& folder) {
  for (int i = 0; i < kWrittenFrames; ++i) {
    const std::string stem = fmt::format("{}", 7000000 + 200000 * i);
    const fs::path keyframes = folder / "keyframes";
    WriteText(keyframes / "images" / (stem + ".png"), ColourFile(i));
    WriteText(keyframes / "depth" / (stem + ".png"), DepthFile(i));
    cv::Mat sure(kHeight, kWidth, CV_8UC1, cv::Scalar(255));
    WriteText(keyframes / "confidence" / (stem + ".png"), Encoded(".png", sure));
    const std::array<double, 16> m = OpenGl(i);
    std::string numbers;
    for (std::size_t k = 0; k < 12; ++k)
      numbers += fmt::format(", \"t_{}{}\": {:.12g}", k / 4, k % 4, m[k]);
    WriteText(
        keyframes / "cameras" / (stem + ".json"),
        R"({"fx": 30.3, "fy": 30.3, "cx": 15.5, "cy": 11.25, "width": 32, "height": 24, "blur_score": 88)" +
            numbers + "}");
  }
}

void WriteNerfstudio(const fs::path& folder) {
  std::string frames;
  for (int i = 0; i < kWrittenFrames; ++i) {
    WriteText(folder / fmt::format("images/frame_{:05d}.png", i), ColourFile(i));
    WriteText(folder / fmt::format("depth/frame_{:05d}.png", i), DepthFile(i));
    frames += fmt::format(
        R"({}{{"file_path": "images/frame_{:05d}.png", "depth_file_path": "depth/frame_{:05d}.png",
             "transform_matrix": {}}})",
        i == 0 ? "" : ", ",
        i,
        i,
        OpenGlRows(i, "[", "]"));
  }
  WriteText(folder / "transforms.json",
            R"({"camera_model": "OPENCV", "fl_x": 30.3, "fl_y": 30.3, "cx": 16.0, "cy": 11.75,
                "w": 32, "h": 24, "k1": 0, "frames": [)" +
                frames + "]}");
}

void WriteArkitScenes(const fs::path& folder) {
  std::string poses;
  for (int i = 0; i < kWrittenFrames; ++i) {
    const std::string stem = fmt::format("41069021_{:.3f}", 300 + 0.1 * i);
    WriteText(folder / "lowres_wide" / (stem + ".png"), ColourFile(i));
    WriteText(folder / "lowres_depth" / (stem + ".png"), DepthFile(i));
    WriteText(folder / "lowres_wide_intrinsics" / (stem + ".pincam"),
              "32 24 30.3 30.3 15.5 11.25\n");
    cv::Mat sure(kHeight, kWidth, CV_8UC1, cv::Scalar(2));
    WriteText(folder / "confidence" / (stem + ".png"), Encoded(".png", sure));
    // Camera from world: a turn by -a about y, then what the camera's place becomes.
    const double a = 0.1 * i;
    const double x = 0.5 * i, z = -2;
    poses += fmt::format("{:.3f} 0 {} 0 {} -1.25 {}\n",
                         300 + 0.1 * i,
                         -a,
                         -(std::cos(a) * x - std::sin(a) * z),
                         -(std::sin(a) * x + std::cos(a) * z));
  }
  WriteText(folder / "lowres_wide.traj", poses);
}

void WriteScanNetPp(const fs::path& folder) {
  std::string frames;
  for (int i = 0; i < kWrittenFrames; ++i) {
    const std::string stem = fmt::format("frame_{:06d}", i);
    WriteText(folder / "rgb" / (stem + ".png"), ColourFile(i));
    WriteText(folder / "depth" / (stem + ".png"), DepthFile(i));
    const std::array<double, 16> m = Matrix(i);
    std::string rows;
    for (std::size_t row = 0; row < 4; ++row) {
      rows += fmt::format("{}[{:.12g}, {:.12g}, {:.12g}, {:.12g}]",
                          row == 0 ? "" : ", ",
                          m[4 * row],
                          m[4 * row + 1],
                          m[4 * row + 2],
                          m[4 * row + 3]);
    }
    frames += fmt::format(
        R"({}"{}": {{"timestamp": {}, "aligned_pose": [{}], "intrinsic": [[30.3, 0, 15.5],
             [0, 30.3, 11.25], [0, 0, 1]], "imu": []}})",
        i == 0 ? "" : ", ",
        stem,
        50 + 0.1 * i,
        rows);
  }
  WriteText(folder / "pose_intrinsic_imu.json", "{" + frames + "}");
}

void WriteRtabMap(const fs::path& folder) {
  std::string poses = "#timestamp x y z qx qy qz qw id\n";
  for (int i = 0; i < kWrittenFrames; ++i) {
    const std::string stem = fmt::format("{:.6f}", 1500 + 0.2 * i);
    WriteText(folder / "flat_rgb" / (stem + ".png"), ColourFile(i));
    WriteText(folder / "flat_depth" / (stem + ".png"), DepthFile(i));
    WriteText(folder / "flat_calib" / (stem + ".yaml"),
              "%YAML:1.0\n---\ncamera_name: \"\"\nimage_width: 32\nimage_height: "
              "24\ncamera_matrix:\n   rows: 3\n   cols: 3\n   data: [ 30.3, 0., 15.5, 0., 30.3, "
              "11.25, 0., 0., 1. ]\nlocal_transform:\n   rows: 3\n   cols: 4\n   data: [ 0., 0., "
              "1., 0., -1., 0., 0., 0., 0., -1., 0., 0. ]\n");
    poses += stem + " " + Tum(i) + fmt::format(" {}\n", i + 1);
  }
  WriteText(folder / "flat_camera_poses.txt", poses);
}

template <typename T>
void Append(std::string& bytes, const std::vector<T>& values) {
  const std::size_t begin = bytes.size();
  bytes.resize(begin + values.size() * sizeof(T));
  std::memcpy(bytes.data() + begin, values.data(), values.size() * sizeof(T));
}

std::string NodeCalibration() {
  std::string bytes;
  Append<std::int32_t>(bytes, {0, 20, 8, 0, kWidth, kHeight, 9, 0, 0, 0, 12});
  Append<double>(bytes, {30.3, 0, 15.5, 0, 30.3, 11.25, 0, 0, 1});
  Append<float>(bytes, {0, 0, 1, 0, -1, 0, 0, 0, 0, -1, 0, 0});
  return bytes;
}

// World from base: the camera's pose times camera from base.
std::string NodePose(int i) {
  const std::array<double, 16> m = Matrix(i);
  std::vector<float> rows;
  for (const std::size_t row : {0U, 4U, 8U}) {
    rows.push_back(static_cast<float>(m[row + 2]));
    rows.push_back(static_cast<float>(-m[row]));
    rows.push_back(static_cast<float>(-m[row + 1]));
    rows.push_back(static_cast<float>(m[row + 3]));
  }
  std::string bytes;
  Append(bytes, rows);
  return bytes;
}

void Bind(sqlite3_stmt* statement, int column, const std::string& bytes) {
  sqlite3_bind_blob(
      statement, column, bytes.data(), static_cast<int>(bytes.size()), SQLITE_TRANSIENT);
}

std::string Shape() { return fmt::format("({}, {})", kHeight, kWidth); }

}  // namespace

std::string OpenGlRows(int i, const std::string& open, const std::string& close) {
  const std::array<double, 16> m = OpenGl(i);
  std::string text = open;
  for (std::size_t row = 0; row < 4; ++row) {
    text += fmt::format("{}{}{:.12g}, {:.12g}, {:.12g}, {:.12g}{}",
                        row == 0 ? "" : ", ",
                        open,
                        m[4 * row],
                        m[4 * row + 1],
                        m[4 * row + 2],
                        m[4 * row + 3],
                        close);
  }
  return text + close;
}

void WriteDatabase(const fs::path& file, int num_nodes) {
  fs::create_directories(file.parent_path());
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  sqlite3_exec(database,
               "CREATE TABLE Node (id INTEGER PRIMARY KEY, map_id INTEGER, weight INTEGER, stamp "
               "FLOAT, pose BLOB, label TEXT);"
               "CREATE TABLE Data (id INTEGER PRIMARY KEY, image BLOB, depth BLOB, calibration "
               "BLOB, scan BLOB);",
               nullptr,
               nullptr,
               nullptr);
  for (int i = 0; i < num_nodes; ++i) {
    sqlite3_stmt* node = nullptr;
    sqlite3_prepare_v2(
        database, "INSERT INTO Node VALUES (?1, 0, 0, ?2, ?3, '')", -1, &node, nullptr);
    sqlite3_bind_int(node, 1, i + 1);
    sqlite3_bind_double(node, 2, 1500 + 0.2 * i);
    Bind(node, 3, NodePose(i));
    EXPECT_EQ(sqlite3_step(node), SQLITE_DONE);
    sqlite3_finalize(node);
    sqlite3_stmt* data = nullptr;
    sqlite3_prepare_v2(
        database, "INSERT INTO Data VALUES (?1, ?2, ?3, ?4, NULL)", -1, &data, nullptr);
    sqlite3_bind_int(data, 1, i + 1);
    Bind(data, 2, ColourFile(i));
    Bind(data, 3, DepthFile(i));
    Bind(data, 4, NodeCalibration());
    EXPECT_EQ(sqlite3_step(data), SQLITE_DONE);
    sqlite3_finalize(data);
  }
  sqlite3_close(database);
}

std::string PgmDepth(int i) {
  std::string bytes = fmt::format("P5\n# millimetres\n{} {}\n65535\n", kWidth, kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const std::uint16_t mm = DepthMm(i, u, v);
      bytes.push_back(static_cast<char>(mm >> 8));
      bytes.push_back(static_cast<char>(mm & 255));
    }
  }
  return bytes;
}

std::string NpyDepth(int i) {
  std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': " + Shape() + ", }";
  header.resize(118, ' ');
  header.back() = '\n';
  std::string bytes = std::string("\x93NUMPY\x01\x00", 8);
  bytes += {static_cast<char>(header.size()), '\0'};
  bytes += header;
  std::vector<float> metres;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) metres.push_back(0.001F * DepthMm(i, u, v));
  }
  Append(bytes, metres);
  return bytes;
}

std::string ExrDepth(int i) {
  ::setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
  cv::Mat metres(kHeight, kWidth, CV_32FC1);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) metres.at<float>(v, u) = 0.001F * DepthMm(i, u, v);
  }
  return Encoded(".exr", metres);
}

std::string TiffDepth(int i) {
  cv::Mat raw(kHeight, kWidth, CV_16UC1);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) raw.at<std::uint16_t>(v, u) = DepthMm(i, u, v);
  }
  return Encoded(".tiff", raw);
}

std::vector<WrittenLayout> WrittenLayouts() {
  return {
      {"3dmatch", WriteThreeDMatch, {"camera-intrinsics.txt", "frame-000001.pose.txt"}},
      {"bundlefusion", WriteBundleFusion, {"info.txt", "frame-000001.pose.txt"}},
      {"3rscan", WriteThreeRScan, {"_info.txt", "frame-000001.pose.txt", "frame-000000.depth.pgm"}},
      {"scannet-export",
       WriteScanNetExport,
       {"intrinsic/intrinsic_color.txt",
        "intrinsic/intrinsic_depth.txt",
        "intrinsic/extrinsic_depth.txt",
        "pose/1.txt"}},
      {"sun3d", WriteSun3d, {"intrinsics.txt", "extrinsics/20140808220511.txt"}, 0.1},
      {"replica", WriteReplica, {"cam_params.json", "traj.txt"}},
      {"habitat", WriteHabitat, {"GT_Pose.txt", "capture.yaml"}},
      {"folders", WriteFolders, {"K.txt", "pose.txt", "capture.yaml", "depth/1.pgm"}},
      {"record3d", WriteRecord3d, {"metadata.json", "depth/0.exr"}, 0.1, true},
      {"polycam", WritePolycam, {"keyframes/cameras/7200000.json"}, 0.2},
      {"nerfstudio", WriteNerfstudio, {"transforms.json"}},
      {"arkitscenes",
       WriteArkitScenes,
       {"lowres_wide.traj", "lowres_wide_intrinsics/41069021_300.100.pincam"},
       0.1},
      {"scannetpp", WriteScanNetPp, {"pose_intrinsic_imu.json"}, 0.1},
      {"rtabmap", WriteRtabMap, {"flat_camera_poses.txt", "flat_calib/1500.200000.yaml"}, 0.2},
      {"rtabmap-db",
       [](const fs::path& folder) { WriteDatabase(folder / "map.db", kWrittenFrames); },
       {"map.db"},
       0.2},
  };
}

}  // namespace deepslam::layouts::foreign
