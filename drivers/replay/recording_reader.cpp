/// Checks types, shapes and sizes before reading, so that HDF5 never reads beyond a buffer.
#include "drivers/replay/recording_reader.hpp"

#include <fcntl.h>
#include <libdeflate.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>

#include "drivers/hdf5/types.hpp"

namespace ovws {
namespace {

using hdf5::Handle;

constexpr hsize_t kMaxRows = hsize_t(1) << 34;
constexpr hsize_t kMaxChunkBytes = 64 << 20;
constexpr std::uint32_t kMaxPartsPerFrame = 4096;  // spots or coefficients of one frame
// Metadata read attempts: an active writer replaces metadata within microseconds. HDF5 doubles its
// wait before each retry. Its default of a hundred attempts never ends on a damaged file.
constexpr unsigned kReadAttempts = 20;
constexpr int kMaxSidePx = 1 << 16;
constexpr std::size_t kMaxAttributeBytes = 256;

struct FreeDecompressor {
  void operator()(libdeflate_decompressor* decompressor) const {
    libdeflate_free_decompressor(decompressor);
  }
};

/// Dataset of rows, or of rows and columns.
struct Rows {
  Handle set;
  hsize_t count = 0, columns = 0;

  /// Whether the row has as many columns.
  bool has(std::uint64_t row, std::uint32_t cells) const {
    return cells == 0 || (row < count && cells <= columns);
  }
};

bool read_attribute(hid_t file, const char* name, hid_t type, void* value) {
  const Handle attribute(H5Aopen(file, name, H5P_DEFAULT), H5Aclose);
  if (!attribute) return false;
  const Handle space(H5Aget_space(attribute), H5Sclose);
  const Handle stored(H5Aget_type(attribute), H5Tclose);
  return space && H5Sget_simple_extent_npoints(space) == 1 && stored &&
         H5Tget_class(stored) == H5Tget_class(type) && H5Aread(attribute, type, value) >= 0;
}

/// Reads a text attribute of variable length.
bool read_attribute(hid_t file, const char* name, std::string& text) {
  const Handle attribute(H5Aopen(file, name, H5P_DEFAULT), H5Aclose);
  if (!attribute) return false;
  const Handle space(H5Aget_space(attribute), H5Sclose);
  const Handle stored(H5Aget_type(attribute), H5Tclose);
  if (!space || H5Sget_simple_extent_npoints(space) != 1 || !stored ||
      H5Tget_class(stored) != H5T_STRING || H5Tis_variable_str(stored) <= 0) {
    return false;
  }
  char* read = nullptr;
  if (H5Aread(attribute, stored, static_cast<void*>(&read)) < 0 || read == nullptr) return false;
  const std::size_t size = ::strnlen(read, kMaxAttributeBytes + 1);
  text.assign(read, size);
  H5free_memory(read);
  return size <= kMaxAttributeBytes;
}

/// Whether the file is large enough for `rows` uncompressed rows. The check prevents huge
/// allocations for a damaged file.
bool fits_file_size(hid_t file, hsize_t rows, std::size_t row_bytes) {
  hsize_t bytes = 0;
  return H5Fget_filesize(file, &bytes) >= 0 && rows <= bytes / row_bytes;
}

/// Whether the dataset's chunks fit into memory.
bool chunks_fit(hid_t layout, int dimensions, std::size_t row_bytes) {
  if (H5Pget_layout(layout) != H5D_CHUNKED) return H5Pget_layout(layout) == H5D_CONTIGUOUS;
  std::array<hsize_t, 2> chunk{1, 1};
  return H5Pget_chunk(layout, dimensions, chunk.data()) == dimensions &&
         chunk[0] <= kMaxChunkBytes / row_bytes &&
         chunk[1] <= kMaxChunkBytes / row_bytes / std::max<hsize_t>(chunk[0], 1);
}

/// Opens a dataset. False unless it exists, has exactly the type `type` and as many dimensions, and
/// its chunks fit into memory.
bool open_rows(hid_t file, const char* name, hid_t type, std::size_t row_bytes, hsize_t max_rows,
               Rows& out, int dimensions = 1) {
  out.set = Handle(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose);
  if (!out.set) return false;
  const Handle stored(H5Dget_type(out.set), H5Tclose);
  const Handle space(H5Dget_space(out.set), H5Sclose);
  const Handle layout(H5Dget_create_plist(out.set), H5Pclose);
  if (!stored || !space || !layout || H5Tequal(stored, type) <= 0 || H5Pget_nfilters(layout) != 0 ||
      H5Pget_external_count(layout) != 0) {
    return false;
  }
  std::array<hsize_t, 2> extent{};
  if (H5Sget_simple_extent_ndims(space) != dimensions ||
      H5Sget_simple_extent_dims(space, extent.data(), nullptr) != dimensions) {
    return false;
  }
  out.count = extent[0];
  out.columns = extent[1];
  // Only datasets of one dimension are read as a whole.
  return out.count <= max_rows && (dimensions == 2 || fits_file_size(file, out.count, row_bytes)) &&
         chunks_fit(layout, dimensions, row_bytes);
}

bool read_rows(const Rows& rows, hid_t type, hsize_t first, hsize_t count, void* out) {
  if (count == 0) return true;
  if (first > rows.count || count > rows.count - first) return false;
  const Handle space(H5Dget_space(rows.set), H5Sclose);
  const Handle memory(H5Screate_simple(1, &count, nullptr), H5Sclose);
  return space && memory &&
         H5Sselect_hyperslab(space, H5S_SELECT_SET, &first, nullptr, &count, nullptr) >= 0 &&
         H5Dread(rows.set, type, memory, space, H5P_DEFAULT, out) >= 0;
}

/// Reads the cells of one frame.
bool read_cells(const Rows& rows, hid_t type, hsize_t row, std::uint32_t cells, void* out) {
  if (cells == 0) return true;
  if (!rows.has(row, cells)) return false;
  const std::array<hsize_t, 2> at{row, 0}, size{1, cells};
  const Handle space(H5Dget_space(rows.set), H5Sclose);
  const Handle memory(H5Screate_simple(2, size.data(), nullptr), H5Sclose);
  return space && memory &&
         H5Sselect_hyperslab(space, H5S_SELECT_SET, at.data(), nullptr, size.data(), nullptr) >=
             0 &&
         H5Dread(rows.set, type, memory, space, H5P_DEFAULT, out) >= 0;
}

template <std::size_t N>
std::string text_of(const std::array<char, N>& text) {
  return {text.begin(), std::find(text.begin(), text.end(), '\0')};
}

/// Reason why a file cannot be opened, found by system calls because HDF5 gives no reason.
std::string open_failure(const std::string& path) {
  if (::faccessat(AT_FDCWD, path.c_str(), R_OK, AT_EACCESS) == 0) {
    return "cannot be opened as HDF5: it is damaged, or not a recording";
  }
  const int error = errno;
  const std::string reason = std::strerror(error);
  if (error != EACCES) return reason;
  return reason +
         "; members of the group ovws-data may read what the service records: sudo adduser $USER "
         "ovws-data, then log in again";
}

}  // namespace

struct RecordingReader::Impl {
  std::string path;
  Handle frame_type = hdf5::row_type(kFrameFields, sizeof(RecordedFrame));
  Handle spot_type = hdf5::row_type(kSpotFields, sizeof(RecordedSpot));
  Handle document_type = hdf5::row_type(kDocumentFields, sizeof(RecordedDocument));
  Handle summary_type = hdf5::row_type(kSummaryFields, sizeof(RecordedSummary));
  Handle file;
  Handle pictures;
  hsize_t image_count = 0;
  Rows spots, coefficients, sigma_waves, text, documents;
  Rows beam_spots;  ///< empty: without further light sources
  RecordingHeader header;
  RecordedSummary summary;
  std::vector<RecordedFrame> frames;
  std::vector<std::byte> packed;
  std::unique_ptr<libdeflate_decompressor, FreeDecompressor> decompressor{
      libdeflate_alloc_decompressor()};

  tl::unexpected<Error> unreadable(const std::string& what) const {
    return fail(Errc::invalid, "path", path + " is damaged (" + what + "): use an intact copy");
  }
  bool open_file();
  bool read_header();
  bool open_images();
  bool open_tables();
  bool read_frames();
  bool is_complete(const RecordedFrame& frame) const;
};

/// Opens for SWMR reading, which ignores the flags that a killed writer has left in the file.
bool RecordingReader::Impl::open_file() {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  H5Pset_metadata_read_attempts(access, kReadAttempts);
  file = Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY | H5F_ACC_SWMR_READ, access), H5Fclose);
  return bool(file);
}

bool RecordingReader::Impl::read_header() {
  std::string schema, format;
  if (!read_attribute(file, "schema", schema) || schema != kRecordingSchema) return false;
  const bool read =
      read_attribute(file, "program", header.program) &&
      read_attribute(file, "pixel_format", format) &&
      read_attribute(file, "camera_vendor", header.vendor) &&
      read_attribute(file, "camera_model", header.model) &&
      read_attribute(file, "camera_serial", header.serial) &&
      read_attribute(file, "t_begin_ns", H5T_NATIVE_INT64, &header.t_begin_ns) &&
      read_attribute(file, "roi_x", H5T_NATIVE_INT, &header.x) &&
      read_attribute(file, "roi_y", H5T_NATIVE_INT, &header.y) &&
      read_attribute(file, "width", H5T_NATIVE_INT, &header.width) &&
      read_attribute(file, "height", H5T_NATIVE_INT, &header.height) &&
      read_attribute(file, "pictures_every", H5T_NATIVE_INT, &header.pictures_every) &&
      read_attribute(file, "frame_rate_hz", H5T_NATIVE_DOUBLE, &header.frame_rate_hz) &&
      read_attribute(file, "wavelength_nm", H5T_NATIVE_DOUBLE, &header.wavelength_nm);
  const auto known = pixel_format_from_name(format);
  if (!read || !known) return false;
  header.format = *known;
  return header.width > 0 && header.width <= kMaxSidePx && header.height > 0 &&
         header.height <= kMaxSidePx && header.width % pixels_per_group(header.format) == 0 &&
         row_bytes(header.format, header.width) * std::size_t(header.height) <=
             kMaxRecordedImageBytes &&
         header.frame_rate_hz > 0.0 && header.frame_rate_hz < 1e6;
}

bool RecordingReader::Impl::open_images() {
  pictures = Handle(H5Dopen2(file, "pictures", H5P_DEFAULT), H5Dclose);
  if (!pictures) return false;
  const Handle stored(H5Dget_type(pictures), H5Tclose);
  const Handle space(H5Dget_space(pictures), H5Sclose);
  const Handle layout(H5Dget_create_plist(pictures), H5Pclose);
  const hid_t type = image_word_bytes(header.format) == 2 ? H5T_STD_U16LE : H5T_STD_U8LE;
  if (!stored || !space || !layout || H5Tequal(stored, type) <= 0 ||
      H5Sget_simple_extent_ndims(space) != 3 || H5Pget_layout(layout) != H5D_CHUNKED) {
    return false;
  }
  std::array<hsize_t, 3> size{}, chunk{};
  if (H5Sget_simple_extent_dims(space, size.data(), nullptr) != 3 ||
      H5Pget_chunk(layout, 3, chunk.data()) != 3) {
    return false;
  }
  image_count = size[0];
  const std::array<hsize_t, 3> one{1, hsize_t(header.height),
                                   hsize_t(image_columns(header.format, header.width))};
  return chunk == one && size[1] == one[1] && size[2] == one[2];
}

bool RecordingReader::Impl::open_tables() {
  Rows last;
  if (!open_rows(file, "summary", summary_type, sizeof(RecordedSummary), 1, last) ||
      !read_rows(last, summary_type, 0, 1, &summary)) {
    return false;
  }
  return open_rows(file, "spots", spot_type, sizeof(RecordedSpot), kMaxRows, spots, 2) &&
         open_rows(file, "coefficients", H5T_IEEE_F32LE, sizeof(float), kMaxRows, coefficients,
                   2) &&
         (H5Lexists(file, "beam_spots", H5P_DEFAULT) <= 0 ||
          open_rows(file, "beam_spots", spot_type, sizeof(RecordedSpot), kMaxRows, beam_spots,
                    2)) &&
         open_rows(file, "sigma_waves", H5T_IEEE_F32LE, sizeof(float), kMaxRows, sigma_waves, 2) &&
         open_rows(file, "documents", document_type, sizeof(RecordedDocument),
                   kMaxRecordedDocuments, documents) &&
         open_rows(file, "text", H5T_STD_U8LE, 1, kMaxRecordedTextBytes, text);
}

bool RecordingReader::Impl::is_complete(const RecordedFrame& frame) const {
  return frame.spots <= kMaxPartsPerFrame && frame.coefficients <= kMaxPartsPerFrame &&
         spots.has(frame.first_spot, frame.spots) &&
         coefficients.has(frame.first_coefficient, frame.coefficients) &&
         sigma_waves.has(frame.first_coefficient, frame.coefficients) && frame.picture >= -1 &&
         frame.picture < std::int64_t(image_count) && frame.left_justified_bits < 16;
}

bool RecordingReader::Impl::read_frames() {
  Rows rows;
  if (!open_rows(file, "frames", frame_type, sizeof(RecordedFrame), kMaxRecordedFrames, rows)) {
    return false;
  }
  frames.resize(rows.count);
  return read_rows(rows, frame_type, 0, rows.count, frames.data());
}

Result<std::unique_ptr<RecordingReader>> RecordingReader::open(const std::string& path) {
  hdf5::silence_errors();
  H5PLset_loading_state(0);  // load no filter plug-ins that the file requests
  auto impl = make_hidden<Impl>();
  impl->path = path;
  if (!impl->open_file()) {
    return fail(Errc::unavailable, "path", path + ": " + open_failure(path));
  }
  if (!impl->read_header()) {
    return fail(Errc::invalid, "path",
                path + " is not a recording of schema " + kRecordingSchema +
                    ": give a file that record.start wrote");
  }
  // Read the frame rows first. While a recording is still being written, the data that these rows
  // refer to are then already in the file.
  if (!impl->read_frames()) return impl->unreadable("its frames");
  if (!impl->open_images()) return impl->unreadable("its images");
  if (!impl->open_tables()) return impl->unreadable("its tables");
  const bool whole = std::all_of(impl->frames.begin(), impl->frames.end(),
                                 [&](const RecordedFrame& one) { return impl->is_complete(one); });
  if (!whole) return impl->unreadable("the file is damaged: data of a frame are missing");
  return std::unique_ptr<RecordingReader>(new RecordingReader(std::move(impl)));
}

const RecordingHeader& RecordingReader::header() const {
  return impl_->header;
}
const std::vector<RecordedFrame>& RecordingReader::frames() const {
  return impl_->frames;
}
std::size_t RecordingReader::image_bytes() const {
  return row_bytes(impl_->header.format, impl_->header.width) * std::size_t(impl_->header.height);
}

std::uint64_t RecordingReader::documents_dropped() const {
  return impl_->summary.documents_dropped;
}

Result<std::vector<RecordedSpot>> RecordingReader::spots(const RecordedFrame& frame) {
  std::vector<RecordedSpot> all(frame.spots);
  if (!read_cells(impl_->spots, impl_->spot_type, frame.first_spot, frame.spots, all.data())) {
    return impl_->unreadable("the file is damaged: the spots of a frame cannot be read");
  }
  return all;
}

Result<std::vector<RecordedSpot>> RecordingReader::beam_spots(const RecordedFrame& frame,
                                                              std::size_t count) {
  const Rows& rows = impl_->beam_spots;
  std::vector<RecordedSpot> all;
  if (count <= rows.columns) all.resize(count);
  if (all.size() != count ||
      !read_cells(rows, impl_->spot_type, frame.first_spot, std::uint32_t(count), all.data())) {
    return impl_->unreadable("the file is damaged: spots of a further light source are missing");
  }
  return all;
}

Result<std::vector<float>> RecordingReader::coefficients(const RecordedFrame& frame) {
  std::vector<float> all(frame.coefficients);
  if (!read_cells(impl_->coefficients, H5T_IEEE_F32LE, frame.first_coefficient, frame.coefficients,
                  all.data())) {
    return impl_->unreadable("the file is damaged: the coefficients of a frame cannot be read");
  }
  return all;
}

Result<std::vector<float>> RecordingReader::sigma_waves(const RecordedFrame& frame) {
  std::vector<float> all(frame.coefficients);
  if (!read_cells(impl_->sigma_waves, H5T_IEEE_F32LE, frame.first_coefficient, frame.coefficients,
                  all.data())) {
    return impl_->unreadable("the file is damaged: the standard errors of a frame cannot be read");
  }
  return all;
}

Result<std::vector<int>> RecordingReader::columns_j() {
  Rows modes;
  if (!open_rows(impl_->file, "mode", H5T_STD_I32LE, sizeof(int), kMaxPartsPerFrame, modes)) {
    return impl_->unreadable("the modes of the columns cannot be read");
  }
  std::vector<int> all(modes.count);
  if (!read_rows(modes, H5T_NATIVE_INT, 0, modes.count, all.data())) {
    return impl_->unreadable("the modes of the columns cannot be read");
  }
  return all;
}

Result<void> RecordingReader::picture(const RecordedFrame& frame, std::span<std::byte> out) {
  Impl& m = *impl_;
  const std::array<hsize_t, 3> at{hsize_t(std::max<std::int64_t>(frame.picture, 0)), 0, 0};
  hsize_t bytes = 0;
  std::uint32_t left_out = 0;
  if (frame.picture < 0 || out.size() != image_bytes() ||
      H5Dget_chunk_storage_size(m.pictures, at.data(), &bytes) < 0 || bytes == 0 ||
      bytes > out.size()) {
    return m.unreadable("an image is missing");
  }
  m.packed.resize(bytes);
  if (H5Dread_chunk(m.pictures, H5P_DEFAULT, at.data(), &left_out, m.packed.data()) < 0) {
    return m.unreadable("an image cannot be read");
  }
  if (left_out != 0) {
    if (bytes != out.size()) return m.unreadable("an image is incomplete");
    std::memcpy(out.data(), m.packed.data(), bytes);
  } else if (!m.decompressor ||
             libdeflate_zlib_decompress(m.decompressor.get(), m.packed.data(), bytes, out.data(),
                                        out.size(), nullptr) != LIBDEFLATE_SUCCESS) {
    return m.unreadable("an image is damaged");
  }
  return {};
}

Result<std::vector<RecordedText>> RecordingReader::documents() {
  Impl& m = *impl_;
  std::vector<RecordedDocument> rows(m.documents.count);
  if (!read_rows(m.documents, m.document_type, 0, m.documents.count, rows.data())) {
    return m.unreadable("documents cannot be read");
  }
  std::vector<RecordedText> all;
  std::uint64_t bytes = 0;
  for (const RecordedDocument& row : rows) {
    bytes += std::min(row.bytes, kMaxRecordedTextBytes);
    if (bytes > kMaxRecordedTextBytes || row.bytes > m.text.count)
      return m.unreadable("a document is too long");
    RecordedText one{text_of(row.kind), text_of(row.sha256), std::string(row.bytes, '\0')};
    if (!read_rows(m.text, H5T_STD_U8LE, row.first_byte, row.bytes, one.text.data())) {
      return m.unreadable("a document cannot be read");
    }
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace ovws
