#include "deepslam/formats/rtabmap_database.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <mutex>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <sqlite3.h>

#include "deepslam/formats/pose_matrix.h"

namespace deepslam::formats {
namespace {

// Version (3), type, width, height, lengths of five matrices.
constexpr std::size_t kHeaderNumbers = 11;
constexpr std::int32_t kMaxNumbers = 64;   // of a matrix in a calibration
constexpr double kMaxTimeS = 1e11;         // s since 1970: 3,000 years; what is beyond is no time
constexpr int kMaxValueBytes = 256 << 20;  // 256 MiB; SQLite refuses longer values

// A piece off the front, as it lies (little-endian); nothing where there are too few bytes.
template <typename T>
std::optional<std::vector<T>> Take(std::string_view& bytes, std::size_t count) {
  if (count * sizeof(T) > bytes.size()) return std::nullopt;
  std::vector<T> values(count);
  if (values.empty()) return values;  // nothing to copy, perhaps from nowhere
  std::memcpy(values.data(), bytes.data(), count * sizeof(T));
  bytes.remove_prefix(count * sizeof(T));
  return values;
}

// Three rows of four.
std::optional<Pose3> PoseOfRows(const std::vector<float>& rows) {
  std::array<double, 16> matrix{};
  std::copy(rows.begin(), rows.end(), matrix.begin());
  matrix[15] = 1;
  return PoseOfMatrix(matrix);
}

Error Damaged() { return InvalidInput("calibration is damaged or of a form that is not read"); }

LensDistortion LensOf(const std::vector<double>& d) {
  // RTAB-Map keeps a fisheye's k1 k2 k3 k4 as k1 k2 0 0 k3 k4.
  if (d.size() == 6) return {LensModel::kFisheye, {d[0], d[1], d[4], d[5]}};
  LensDistortion lens{d.size() >= 8 ? LensModel::kRational : LensModel::kRadialTangential, {}};
  const auto most = static_cast<std::size_t>(LensDistortion::NumCoefficients(lens.model));
  std::copy_n(d.begin(), std::min(d.size(), most), lens.coefficients.begin());
  return lens;
}

bool AllFinite(const std::vector<double>& numbers) {
  return std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); });
}

Result<NodeCamera> ParseSerialised(std::string_view bytes) {
  const auto header = Take<std::int32_t>(bytes, kHeaderNumbers);
  if (!header) return Damaged();
  const std::vector<std::int32_t>& h = *header;
  for (std::size_t i = 6; i < kHeaderNumbers; ++i) {
    if (h[i] < 0 || h[i] > kMaxNumbers) return Damaged();
  }
  const auto count = [&](std::size_t i) { return static_cast<std::size_t>(h[i]); };
  const auto k = Take<double>(bytes, count(6));
  const auto d = k ? Take<double>(bytes, count(7)) : std::nullopt;
  const auto r = d ? Take<double>(bytes, count(8)) : std::nullopt;
  const auto p = r ? Take<double>(bytes, count(9)) : std::nullopt;
  const auto local = p ? Take<float>(bytes, count(10)) : std::nullopt;
  if (!local || !AllFinite(*k) || !AllFinite(*d) || !AllFinite(*p)) return Damaged();
  if (!bytes.empty()) return InvalidInput("several cameras in one node are not read");
  NodeCamera node;
  // With a projection matrix the images were rectified to it before they were kept.
  if (p->size() == 12) {
    node.camera = {h[4], h[5], (*p)[0], (*p)[5], (*p)[2], (*p)[6]};
  } else if (k->size() == 9) {
    node.camera = {h[4], h[5], (*k)[0], (*k)[4], (*k)[2], (*k)[5]};
    if (!d->empty()) node.lens = LensOf(*d);
  } else {
    return Damaged();
  }
  if (local->empty()) return node;
  const std::optional<Pose3> pose = local->size() == 12 ? PoseOfRows(*local) : std::nullopt;
  if (!pose) return Damaged();
  node.base_from_camera = *pose;
  return node;
}

// fx fy cx cy width height and three rows of the transform.
Result<NodeCamera> ParseFloats(std::string_view bytes) {
  const auto numbers = Take<float>(bytes, 18);
  if (!numbers) return Damaged();
  const std::vector<float>& n = *numbers;
  const std::optional<Pose3> pose = PoseOfRows({n.begin() + 6, n.end()});
  if (!pose || !(n[4] >= 0 && n[4] <= 16384 && n[5] >= 0 && n[5] <= 16384)) return Damaged();
  return NodeCamera{{static_cast<int>(n[4]),
                     static_cast<int>(n[5]),
                     static_cast<double>(n[0]),
                     static_cast<double>(n[1]),
                     static_cast<double>(n[2]),
                     static_cast<double>(n[3])},
                    std::nullopt,
                    *pose};
}

struct Finalize {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Statement = std::unique_ptr<sqlite3_stmt, Finalize>;

std::string Blob(sqlite3_stmt& statement, int column) {
  const int count = sqlite3_column_bytes(&statement, column);
  const void* const bytes = sqlite3_column_blob(&statement, column);
  if (bytes == nullptr || count <= 0) return {};
  return {static_cast<const char*>(bytes), static_cast<std::size_t>(count)};
}

}  // namespace

Result<NodeCamera> ParseNodeCamera(std::string_view bytes) {
  if (bytes.size() == 18 * sizeof(float)) return ParseFloats(bytes);
  std::string_view left = bytes;
  const auto header = Take<std::int32_t>(left, 4);
  if (header && (*header)[3] != 0)
    return InvalidInput("calibrations of stereo cameras are not read");
  return ParseSerialised(bytes);
}

struct RtabMapDatabase::Impl {
  std::filesystem::path file;
  sqlite3* connection = nullptr;
  std::mutex mutex;

  ~Impl() { sqlite3_close(connection); }

  [[nodiscard]] Error Fault() const {
    return InvalidInput(
        fmt::format("{}: is no database of RTAB-Map that can be read ({}); export it: "
                    "rtabmap-export --images_id --poses_camera --poses_format 10",
                    file.string(),
                    sqlite3_errmsg(connection)));
  }
  Result<Statement> Prepare(const char* query) {
    sqlite3_stmt* statement = nullptr;
    if (sqlite3_prepare_v2(connection, query, -1, &statement, nullptr) != SQLITE_OK) return Fault();
    return Statement(statement);
  }
};

RtabMapDatabase::RtabMapDatabase(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RtabMapDatabase::~RtabMapDatabase() = default;

Result<std::unique_ptr<RtabMapDatabase>> RtabMapDatabase::Open(const std::filesystem::path& file) {
  auto impl = std::make_unique<Impl>();
  impl->file = file;
  if (sqlite3_open_v2(file.c_str(), &impl->connection, SQLITE_OPEN_READONLY, nullptr) != SQLITE_OK)
    return impl->Fault();
  sqlite3_limit(impl->connection, SQLITE_LIMIT_LENGTH, kMaxValueBytes);
  return std::unique_ptr<RtabMapDatabase>(new RtabMapDatabase(std::move(impl)));
}

Result<std::vector<Node>> RtabMapDatabase::Nodes() const {
  const std::lock_guard lock(impl_->mutex);
  Result<Statement> statement = impl_->Prepare(
      "SELECT Node.id, Node.stamp, Node.pose FROM Node JOIN Data ON Node.id = Data.id "
      "WHERE length(Data.image) > 0 AND length(Data.depth) > 0 ORDER BY Node.id");
  if (!statement) return statement.error();
  std::vector<Node> nodes;
  int step = SQLITE_ROW;
  while ((step = sqlite3_step(statement->get())) == SQLITE_ROW) {
    Node node;
    node.id = sqlite3_column_int64(statement->get(), 0);
    node.time_s = sqlite3_column_double(statement->get(), 1);
    if (!(std::abs(node.time_s) < kMaxTimeS)) node.time_s = 0;
    const std::string pose = Blob(*statement->get(), 2);
    std::string_view bytes = pose;
    const auto rows = Take<float>(bytes, 12);
    if (rows && bytes.empty()) node.world_from_base = PoseOfRows(*rows);
    nodes.push_back(node);
  }
  if (step != SQLITE_DONE) return impl_->Fault();
  return nodes;
}

Result<NodeImages> RtabMapDatabase::Images(std::int64_t id) const {
  const std::lock_guard lock(impl_->mutex);
  Result<Statement> statement =
      impl_->Prepare("SELECT image, depth, calibration FROM Data WHERE id = ?1");
  if (!statement) return statement.error();
  sqlite3_bind_int64(statement->get(), 1, id);
  if (sqlite3_step(statement->get()) != SQLITE_ROW) return impl_->Fault();
  return NodeImages{
      Blob(*statement->get(), 0), Blob(*statement->get(), 1), Blob(*statement->get(), 2)};
}

}  // namespace deepslam::formats
