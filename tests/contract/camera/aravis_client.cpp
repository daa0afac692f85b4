/// Helper program: opens a camera, streams, reports it, and waits to be killed.
#include <unistd.h>

#include <iostream>

#include "drivers/aravis/aravis_camera.hpp"

int main(int, char** argv) {
  ovws::AravisConfig config;
  config.id = argv[1];
  auto camera = ovws::open_aravis_camera(config);
  if (!camera || !(*camera)->start()) return 1;
  ovws::GrabbedFrame frame;
  while ((*camera)->grab(frame, std::chrono::seconds(1)) != ovws::GrabStatus::frame) {
  }
  std::cout << "streaming" << std::endl;
  pause();
}
