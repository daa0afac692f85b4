/// Recording in HDF5 SWMR mode (single writer, multiple readers): nothing in the file refers to
/// data that is not yet written.
#include "drivers/record/record_file.hpp"

#include <libdeflate.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "core/optics/zernike.hpp"
#include "core/port/clock.hpp"
#include "drivers/hdf5/types.hpp"
#include "drivers/record/tables.hpp"

namespace ovws {
namespace {

using hdf5::Handle;
using hdf5::Matrix;
using hdf5::Table;
using hdf5::write_attribute;

constexpr hsize_t kTableChunk = 1024;  // rows per chunk of a dataset
constexpr hsize_t kScaleChunk = 64;    // columns per chunk of their names
constexpr hsize_t kTextChunk = 1 << 16;
// Deflate level, compatible with HDF5's built-in filter. Level 1 is two to four times as fast as
// higher levels, which save only a few percent more.
constexpr int kDeflateLevel = 1;
constexpr float kNoValue = std::numeric_limits<float>::quiet_NaN();
constexpr RecordedSpot kNoSpot{kNoValue, kNoValue};
constexpr unsigned kDeflated = 0;      // filter mask of H5Dwrite_chunk: all filters applied
constexpr unsigned kUncompressed = 1;  // filter mask: the first filter (deflate) is skipped

struct FreeCompressor {
  void operator()(libdeflate_compressor* compressor) const {
    libdeflate_free_compressor(compressor);
  }
};

tl::unexpected<Error> failed(const std::string& path, const std::string& what) {
  const std::string why = errno == 0 ? "" : std::string(" (") + std::strerror(errno) + ")";
  return fail(
      Errc::unavailable, "path",
      path + ": " + what + why + "; check the free disk space and the folder's permissions");
}

bool write_header(hid_t file, const RecordingHeader& header) {
  return write_attribute(file, "schema", kRecordingSchema) &&
         write_attribute(file, "program", header.program) &&
         write_attribute(file, "pixel_format", std::string(pixel_format_name(header.format))) &&
         write_attribute(file, "basis", kBasisName) &&
         write_attribute(file, "orientation", kOrientationName) &&
         write_attribute(file, "t_begin_ns", H5T_NATIVE_INT64, &header.t_begin_ns) &&
         write_attribute(file, "camera_vendor", header.vendor) &&
         write_attribute(file, "camera_model", header.model) &&
         write_attribute(file, "camera_serial", header.serial) &&
         write_attribute(file, "frame_rate_hz", H5T_NATIVE_DOUBLE, &header.frame_rate_hz) &&
         write_attribute(file, "roi_x", H5T_NATIVE_INT, &header.x) &&
         write_attribute(file, "roi_y", H5T_NATIVE_INT, &header.y) &&
         write_attribute(file, "width", H5T_NATIVE_INT, &header.width) &&
         write_attribute(file, "height", H5T_NATIVE_INT, &header.height) &&
         write_attribute(file, "pictures_every", H5T_NATIVE_INT, &header.pictures_every) &&
         write_attribute(file, "wavelength_nm", H5T_NATIVE_DOUBLE, &header.wavelength_nm);
}

bool write_units(hid_t file, const char* table, std::span<const RecordedField> fields) {
  const Handle set(H5Dopen2(file, table, H5P_DEFAULT), H5Dclose);
  if (!set) return false;
  for (const RecordedField& field : fields) {
    if (*field.unit == '\0') continue;
    if (!write_attribute(set, std::string("unit.") + field.name, field.unit)) return false;
  }
  return true;
}

bool create_images(hid_t file, const RecordingHeader& header) {
  const std::array<hsize_t, 3> none{0, hsize_t(header.height),
                                    hsize_t(image_columns(header.format, header.width))};
  const std::array<hsize_t, 3> most{H5S_UNLIMITED, none[1], none[2]};
  const std::array<hsize_t, 3> chunk{1, none[1], none[2]};
  const Handle space(H5Screate_simple(3, none.data(), most.data()), H5Sclose);
  const Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  if (H5Pset_chunk(layout, 3, chunk.data()) < 0 || H5Pset_deflate(layout, 1) < 0) return false;
  const hid_t type = image_word_bytes(header.format) == 2 ? H5T_STD_U16LE : H5T_STD_U8LE;
  const Handle set(H5Dcreate2(file, "pictures", type, space, H5P_DEFAULT, layout, H5P_DEFAULT),
                   H5Dclose);
  return set && write_attribute(set, "unit", "DN");
}

/// Name of a mode, of fixed length: SWMR writing allows no text of variable length.
using ModeName = std::array<char, 40>;

ModeName name_of_mode(int j) {
  ModeName name{};
  if (j > 0) zernike_name(j).copy(name.data(), name.size() - 1);
  return name;
}

Handle mode_name_type() {
  Handle text(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(text, std::tuple_size_v<ModeName>);
  H5Tset_strpad(text, H5T_STR_NULLPAD);
  H5Tset_cset(text, H5T_CSET_UTF8);
  return text;
}

/// The dimension scales: `time` of the frames, `mode` and `spot` of the columns.
bool create_scales(hid_t file) {
  constexpr std::array kFrames{
      hdf5::ScaledDimension{"frames", 0}, hdf5::ScaledDimension{"coefficients", 0},
      hdf5::ScaledDimension{"sigma_waves", 0}, hdf5::ScaledDimension{"spots", 0}};
  constexpr std::array kModes{hdf5::ScaledDimension{"coefficients", 1},
                              hdf5::ScaledDimension{"sigma_waves", 1},
                              hdf5::ScaledDimension{"mode_name", 0}};
  constexpr std::array kSpots{hdf5::ScaledDimension{"spots", 1}};
  const auto add_units = [file](const char* name, const char* units) {
    const Handle set(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose);
    return set && write_attribute(set, "units", std::string(units));
  };
  return Table::create(file, "time", H5T_STD_I64LE, kTableChunk) &&
         Table::create(file, "mode", H5T_STD_I32LE, kScaleChunk) &&
         Table::create(file, "mode_name", mode_name_type(), kScaleChunk) &&
         Table::create(file, "spot", H5T_STD_I32LE, kScaleChunk) &&
         hdf5::make_scale(file, "time", kFrames) && hdf5::make_scale(file, "mode", kModes) &&
         hdf5::make_scale(file, "spot", kSpots) &&
         add_units("time", "nanoseconds since 1970-01-01T00:00:00Z") &&
         add_units("coefficients", "wave") && add_units("sigma_waves", "wave");
}

Handle row_of_one() {
  const hsize_t one = 1;
  return {H5Screate_simple(1, &one, nullptr), H5Sclose};
}

}  // namespace

struct RecordFile::Impl {
  std::string path;
  bool broken = false;  ///< a write failed: later data would not match the file's contents
  Handle frame_type = hdf5::row_type(kFrameFields, sizeof(RecordedFrame));
  Handle spot_type = hdf5::row_type(kSpotFields, sizeof(RecordedSpot));
  Handle document_type = hdf5::row_type(kDocumentFields, sizeof(RecordedDocument));
  Handle summary_type = hdf5::row_type(kSummaryFields, sizeof(RecordedSummary));
  Handle name_type = mode_name_type();
  Handle file;  // order matters: datasets are closed first, then the file, then the types
  Handle pictures, summary;
  Table frames, documents, text, time, mode, mode_name, spot;
  Matrix spots, coefficients, sigma_waves;
  Matrix beam_spots;  ///< not open: the file has none
  std::unique_ptr<libdeflate_compressor, FreeCompressor> compressor;
  std::vector<std::byte> packed;
  hsize_t image_count = 0;
  std::uint64_t flushed_frames = 0, flushed_images = 0;
  struct stat created {};
  hsize_t height = 0, columns = 0;
  std::vector<int> modes_j;  ///< of the columns of `coefficients`; 0: it changed
  bool modes_written = false;
  std::vector<RecordedFrame> new_frames;
  std::vector<RecordedSpot> new_spots, new_beam_spots;
  std::vector<std::uint32_t> new_beam_counts;  ///< beam_spots of each frame
  std::vector<float> new_coefficients, new_sigma_waves;
  std::vector<RecordedDocument> new_documents;

  Impl(std::string file_path, const RecordingHeader& header)
      : path(std::move(file_path)),
        compressor(libdeflate_alloc_compressor(kDeflateLevel)),
        packed(row_bytes(header.format, header.width) * std::size_t(header.height)),
        height(hsize_t(header.height)),
        columns(hsize_t(image_columns(header.format, header.width))) {}

  std::span<const std::byte> pack(std::span<const std::byte> picture);
  bool create(const RecordingHeader& header, RecordedWidth expected);
  bool create_tables(const RecordingHeader& header, RecordedWidth expected);
  RecordedSummary summary_with(const RecordedLosses& dropped) const;
  bool begin_swmr(RecordedWidth expected);
  bool write_summary(const RecordedSummary& now);
  bool append_all();
  bool append_cells();
  bool append_beam_spots();
  bool write_column_names();
  tl::unexpected<Error> mark_broken(const std::string& what) {
    broken = true;
    return failed(path, what);
  }
};

/// Deflate compression, lossless. Empty if the image would not become smaller.
std::span<const std::byte> RecordFile::Impl::pack(std::span<const std::byte> picture) {
  if (!compressor) return {};
  return std::span(packed).first(libdeflate_zlib_compress(
      compressor.get(), picture.data(), picture.size(), packed.data(), packed.size()));
}

bool RecordFile::Impl::create_tables(const RecordingHeader& header, RecordedWidth expected) {
  const Handle one = row_of_one();
  const Handle made(
      H5Dcreate2(file, "summary", summary_type, one, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      H5Dclose);
  const RecordedSummary nothing;
  return made && H5Dwrite(made, summary_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, &nothing) >= 0 &&
         create_images(file, header) && Table::create(file, "frames", frame_type, kTableChunk) &&
         Matrix::create(file, "spots", spot_type, expected.spots, &kNoSpot) &&
         (expected.beams == 0 || (Matrix::create(file, "beam_spots", spot_type,
                                                 expected.beams * expected.spots, &kNoSpot) &&
                                  write_units(file, "beam_spots", kSpotFields))) &&
         Matrix::create(file, "coefficients", H5T_IEEE_F32LE, expected.modes, &kNoValue) &&
         Matrix::create(file, "sigma_waves", H5T_IEEE_F32LE, expected.modes, &kNoValue) &&
         Table::create(file, "documents", document_type, kTableChunk) &&
         Table::create(file, "text", H5T_STD_U8LE, kTextChunk) &&
         write_units(file, "frames", kFrameFields) && write_units(file, "spots", kSpotFields) &&
         write_units(file, "summary", kSummaryFields) && create_scales(file);
}

/// Switches to SWMR writing: from here on HDF5 writes data before the references to the data.
bool RecordFile::Impl::begin_swmr(RecordedWidth expected) {
  if (H5Fstart_swmr_write(file) < 0) return false;
  pictures = Handle(H5Dopen2(file, "pictures", H5P_DEFAULT), H5Dclose);
  summary = Handle(H5Dopen2(file, "summary", H5P_DEFAULT), H5Dclose);
  return pictures && summary && frames.open(file, "frames") && spots.open(file, "spots") &&
         (expected.beams == 0 || beam_spots.open(file, "beam_spots")) &&
         coefficients.open(file, "coefficients") && sigma_waves.open(file, "sigma_waves") &&
         documents.open(file, "documents") && text.open(file, "text") && time.open(file, "time") &&
         mode.open(file, "mode") && mode_name.open(file, "mode_name") && spot.open(file, "spot");
}

bool RecordFile::Impl::create(const RecordingHeader& header, RecordedWidth expected) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  errno = 0;
  file = Handle(H5Fcreate(path.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, access), H5Fclose);
  return file && write_header(file, header) && create_tables(header, expected) &&
         begin_swmr(expected);
}

RecordedSummary RecordFile::Impl::summary_with(const RecordedLosses& dropped) const {
  return {.frames = frames.rows(),
          .frames_dropped = dropped.frames,
          .pictures = image_count,
          .pictures_dropped = dropped.pictures,
          .documents_dropped = dropped.documents,
          .t_written_ns = utc_ns()};
}

bool RecordFile::Impl::write_summary(const RecordedSummary& now) {
  return H5Dwrite(summary, summary_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, &now) >= 0 &&
         H5Dflush(summary) >= 0;
}

Result<std::unique_ptr<RecordFile>> RecordFile::create(const std::string& path,
                                                       const RecordingHeader& header,
                                                       RecordedWidth expected) {
  hdf5::silence_errors();
  auto impl = make_hidden<Impl>(path, header);
  if (!impl->create(header, expected)) {
    const auto error = failed(path, "the recording cannot be started");
    const bool file_created = bool(impl->file);
    impl.reset();
    if (file_created) ::unlink(path.c_str());
    return error;
  }
  (void)::stat(path.c_str(), &impl->created);
  return std::unique_ptr<RecordFile>(new RecordFile(std::move(impl)));
}

Result<std::int64_t> RecordFile::add_image(std::span<const std::byte> pixels, bool compress) {
  Impl& m = *impl_;
  errno = 0;
  if (m.broken) return m.mark_broken("an earlier write failed");
  const auto packed = compress ? m.pack(pixels) : std::span<const std::byte>{};
  const auto chunk = packed.empty() ? pixels : packed;
  const std::array<hsize_t, 3> extent{m.image_count + 1, m.height, m.columns};
  const std::array<hsize_t, 3> at{m.image_count, 0, 0};
  if (H5Dset_extent(m.pictures, extent.data()) < 0 ||
      H5Dwrite_chunk(m.pictures, H5P_DEFAULT, packed.empty() ? kUncompressed : kDeflated, at.data(),
                     chunk.size(), chunk.data()) < 0) {
    return m.mark_broken("an image cannot be written");
  }
  return std::int64_t(m.image_count++);
}

void RecordFile::add_frame(RecordedFrame frame, std::span<const RecordedSpot> spots,
                           std::span<const float> coefficients, std::span<const float> sigma_waves,
                           std::span<const RecordedSpot> beam_spots) {
  Impl& m = *impl_;
  frame.first_spot = frame.first_coefficient = m.frames.rows() + m.new_frames.size();
  frame.spots = std::uint32_t(spots.size());
  frame.coefficients = std::uint32_t(coefficients.size());
  m.new_frames.push_back(frame);
  m.new_spots.insert(m.new_spots.end(), spots.begin(), spots.end());
  m.new_coefficients.insert(m.new_coefficients.end(), coefficients.begin(), coefficients.end());
  m.new_sigma_waves.insert(m.new_sigma_waves.end(), sigma_waves.begin(), sigma_waves.end());
  m.new_sigma_waves.resize(m.new_coefficients.size(), NAN);  // the rows of both belong together
  if (!m.beam_spots.is_open()) return;
  m.new_beam_spots.insert(m.new_beam_spots.end(), beam_spots.begin(), beam_spots.end());
  m.new_beam_counts.push_back(std::uint32_t(beam_spots.size()));
}

void RecordFile::name_modes(std::span<const int> modes_j) {
  Impl& m = *impl_;
  m.modes_written = false;
  for (std::size_t k = 0; k < modes_j.size(); ++k) {
    if (k == m.modes_j.size()) m.modes_j.push_back(modes_j[k]);
    if (m.modes_j[k] != modes_j[k]) m.modes_j[k] = 0;
  }
}

Result<void> RecordFile::add_document(std::string_view kind, std::string_view sha256,
                                      std::string_view text) {
  Impl& m = *impl_;
  if (m.text.rows() + text.size() > kMaxRecordedTextBytes ||
      m.documents.rows() + m.new_documents.size() >= kMaxRecordedDocuments) {
    return fail(Errc::refused, "path",
                m.path +
                    ": the recording is full, because the settings, the hologram or the wavefront "
                    "changed too often: start another one with record.start");
  }
  RecordedDocument row;
  kind.copy(row.kind.data(), row.kind.size() - 1);
  sha256.copy(row.sha256.data(), row.sha256.size());
  row.from_frame = frames();
  row.first_byte = m.text.rows();
  row.bytes = text.size();
  errno = 0;
  if (m.broken || !m.text.append(std::span(text.data(), text.size()), H5T_STD_U8LE)) {
    return m.mark_broken("a document cannot be written");
  }
  m.new_documents.push_back(row);
  return {};
}

std::uint64_t RecordFile::frames() const {
  const Impl& m = *impl_;
  return m.broken ? m.flushed_frames : m.frames.rows() + m.new_frames.size();
}
std::uint64_t RecordFile::pictures() const {
  return impl_->broken ? impl_->flushed_images : impl_->image_count;
}
std::uint64_t RecordFile::bytes() const {
  std::error_code failed;  // the size by path works for a closed file, too
  const std::uintmax_t size = std::filesystem::file_size(impl_->path, failed);
  return failed ? 0 : size;
}

bool RecordFile::in_place() const {
  struct stat now {};
  return ::stat(impl_->path.c_str(), &now) == 0 && now.st_ino == impl_->created.st_ino &&
         now.st_dev == impl_->created.st_dev;
}

/// Writes one value of the dimension scales for each column.
bool RecordFile::Impl::write_column_names() {
  if (spot.rows() < spots.columns()) {
    std::vector<int> numbers(spots.columns());
    std::iota(numbers.begin(), numbers.end(), 0);
    if (!spot.overwrite(std::span<const int>(numbers), H5T_NATIVE_INT) || !spot.flush()) {
      return false;
    }
  }
  if (modes_written && mode.rows() == coefficients.columns()) return true;
  std::vector<int> numbers = modes_j;
  numbers.resize(coefficients.columns());
  std::vector<ModeName> names(numbers.size());
  std::ranges::transform(numbers, names.begin(), name_of_mode);
  modes_written = true;
  return mode.overwrite(std::span<const int>(numbers), H5T_NATIVE_INT) && mode.flush() &&
         mode_name.overwrite(std::span<const ModeName>(names), name_type) && mode_name.flush();
}

bool RecordFile::Impl::append_beam_spots() {
  return !beam_spots.is_open() || (beam_spots.append(std::span<const RecordedSpot>(new_beam_spots),
                                                     new_beam_counts, spot_type) &&
                                   beam_spots.flush());
}

/// Appends spots, coefficients and standard errors of the new frames.
bool RecordFile::Impl::append_cells() {
  std::vector<std::uint32_t> spot_counts, mode_counts;
  std::vector<std::int64_t> times;
  for (const RecordedFrame& frame : new_frames) {
    spot_counts.push_back(frame.spots);
    mode_counts.push_back(frame.coefficients);
    times.push_back(frame.t_arrival_ns);
  }
  return spots.append(std::span<const RecordedSpot>(new_spots), spot_counts, spot_type) &&
         spots.flush() && append_beam_spots() &&
         coefficients.append(std::span<const float>(new_coefficients), mode_counts,
                             H5T_IEEE_F32LE) &&
         coefficients.flush() &&
         sigma_waves.append(std::span<const float>(new_sigma_waves), mode_counts, H5T_IEEE_F32LE) &&
         sigma_waves.flush() && write_column_names() &&
         time.append(std::span<const std::int64_t>(times), H5T_STD_I64LE) && time.flush();
}

/// Appends the rows of `frames` last, so that the spots, coefficients and images that they refer to
/// are already written.
bool RecordFile::Impl::append_all() {
  return text.flush() &&
         documents.append(std::span<const RecordedDocument>(new_documents), document_type) &&
         documents.flush() && H5Dflush(pictures) >= 0 && append_cells() &&
         frames.append(std::span<const RecordedFrame>(new_frames), frame_type) && frames.flush();
}

Result<void> RecordFile::flush(const RecordedLosses& dropped) {
  Impl& m = *impl_;
  errno = 0;
  if (m.broken || !m.append_all()) return m.mark_broken("the recording cannot be written");
  m.new_documents.clear();
  m.new_spots.clear();
  m.new_beam_spots.clear();
  m.new_beam_counts.clear();
  m.new_coefficients.clear();
  m.new_sigma_waves.clear();
  m.new_frames.clear();
  const RecordedSummary now = m.summary_with(dropped);
  if (!m.write_summary(now)) return m.mark_broken("the recording cannot be written");
  m.flushed_frames = now.frames;
  m.flushed_images = now.pictures;
  return {};
}

Result<void> RecordFile::close(const RecordedLosses& dropped) {
  if (auto flushed = flush(dropped); !flushed) return flushed;
  Impl& m = *impl_;
  RecordedSummary last = m.summary_with(dropped);
  last.ended = 1;
  errno = 0;
  const bool closed = m.write_summary(last) && m.pictures.close() && m.summary.close() &&
                      m.frames.close() && m.spots.close() && m.beam_spots.close() &&
                      m.coefficients.close() && m.sigma_waves.close() && m.documents.close() &&
                      m.text.close() && m.time.close() && m.mode.close() && m.mode_name.close() &&
                      m.spot.close() && m.file.close();
  if (!closed) return m.mark_broken("the recording cannot be closed");
  return {};
}

}  // namespace ovws
