/// Fake GigE Vision camera in a process of its own, so that a test can freeze and kill it.
/// fake_gige_camera ADDRESS XML_FILE|- LOST_PACKET_RATIO; then "read ADDRESS" and "write ADDRESS
/// VALUE" lines on standard input are answered with the register's value; it ends with its standard
/// input.
#include <arv.h>

#include <cstdint>
#include <cstring>
#include <iostream>
#include <string>

namespace {

constexpr guint32 kSensorWidth = 1280;
constexpr guint32 kSensorHeight = 1024;

/// Sensor pixel (X, Y) holds X + 2 Y, truncated to the format's bits.
void fill(ArvBuffer* buffer, void* camera, guint32, guint32, ArvPixelFormat format) {
  guint32 x0 = 0;
  guint32 y0 = 0;
  arv_fake_camera_read_register(static_cast<ArvFakeCamera*>(camera),
                                ARV_FAKE_CAMERA_REGISTER_X_OFFSET, &x0);
  arv_fake_camera_read_register(static_cast<ArvFakeCamera*>(camera),
                                ARV_FAKE_CAMERA_REGISTER_Y_OFFSET, &y0);
  const guint32 width = guint32(arv_buffer_get_image_width(buffer));
  const guint32 height = guint32(arv_buffer_get_image_height(buffer));
  auto* data = static_cast<std::uint8_t*>(const_cast<void*>(arv_buffer_get_data(buffer, nullptr)));
  constexpr guint32 kMono12p = 0x010c0047;
  const guint32 mask = format == ARV_PIXEL_FORMAT_MONO_12 || format == kMono12p ? 0xfff : 0xffff;
  for (guint32 y = 0; y < height; ++y)
    for (guint32 x = 0; x < width; ++x) {
      const guint32 value = (x0 + x + 2 * (y0 + y)) & mask;
      const std::size_t pixel = std::size_t(y) * width + x;
      if (ARV_PIXEL_FORMAT_BIT_PER_PIXEL(format) == 8) {
        data[pixel] = std::uint8_t(value);
      } else if (format == kMono12p) {
        std::uint8_t* const pair = data + pixel / 2 * 3;
        if (pixel % 2 == 0) {
          pair[0] = std::uint8_t(value);
          pair[1] = std::uint8_t((pair[1] & 0xf0U) | value >> 8);
        } else {
          pair[1] = std::uint8_t((pair[1] & 0x0fU) | value << 4);
          pair[2] = std::uint8_t(value >> 4);
        }
      } else {
        data[2 * pixel] = std::uint8_t(value);
        data[2 * pixel + 1] = std::uint8_t(value >> 8);
      }
    }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: fake_gige_camera ADDRESS XML_FILE|- LOST_PACKET_RATIO\n";
    return 2;
  }
  const char* xml = std::strcmp(argv[2], "-") == 0 ? nullptr : argv[2];
  auto* gige = ARV_GV_FAKE_CAMERA(g_object_new(ARV_TYPE_GV_FAKE_CAMERA, "interface-name", argv[1],
                                               "serial-number", "OVWS7", "genicam-filename", xml,
                                               "gvsp-lost-ratio", std::stod(argv[3]), nullptr));
  ArvFakeCamera* camera = arv_gv_fake_camera_get_fake_camera(gige);
  arv_fake_camera_write_register(camera, ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, kSensorWidth);
  arv_fake_camera_write_register(camera, ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, kSensorHeight);
  arv_fake_camera_set_fill_pattern(camera, fill, camera);
  std::cout << "ready" << std::endl;

  for (std::string word, address; std::cin >> word >> address;) {
    const auto at = guint32(std::stoul(address, nullptr, 0));
    guint32 value = 0;
    if (word == "write" && std::cin >> value) arv_fake_camera_write_register(camera, at, value);
    arv_fake_camera_read_register(camera, at, &value);
    std::cout << value << std::endl;
  }
  return 0;
}
