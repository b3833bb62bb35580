#include "geo/reference_frames.h"

#include <charconv>
#include <cmath>

#include "core/status.h"

namespace insitu::geo {

namespace {

[[noreturn]] void refuse(const std::string& what) {
  throw core::Error(INSITU_ERROR_ARGUMENT, what);
}

std::string number(double value) {
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

} // namespace

Frame Frame::geocentric() {
  Frame frame;
  frame.kind = FrameKind::geocentric;
  return frame;
}

Frame Frame::geodetic(bool depth_down) {
  Frame frame;
  frame.kind = FrameKind::geodetic;
  frame.depth_down = depth_down;
  return frame;
}

Frame Frame::geodetic(const ChartUnits& units) {
  Frame frame = geodetic(units.down);
  frame.radians = units.radians;
  frame.kilometres = units.kilometres;
  return frame;
}

Frame Frame::enu(double longitude, double latitude, double height) {
  Frame frame;
  frame.kind = FrameKind::enu;
  frame.longitude = longitude;
  frame.latitude = latitude;
  frame.height = height;
  validate(frame);
  return frame;
}

Frame Frame::utm(int zone, bool north, bool depth_down) {
  Frame frame;
  frame.kind = FrameKind::utm;
  frame.zone = zone;
  frame.north = north;
  frame.depth_down = depth_down;
  validate(frame);
  return frame;
}

Frame Frame::utm(std::string_view text) {
  const std::string quoted = "utm zone '" + std::string(text) + "'";
  int zone = 0;
  const char* const last = text.data() + text.size();
  const std::from_chars_result digits = std::from_chars(text.data(), last, zone);
  const char* rest = digits.ptr;
  while (rest != last && *rest == ' ')
    ++rest;
  if (digits.ec != std::errc() || last - rest != 1)
    refuse(quoted + ": a number from 1 to 60 and N or S expected, such as '33N'");
  const char hemisphere = *rest;
  if (hemisphere != 'N' && hemisphere != 'n' && hemisphere != 'S' && hemisphere != 's') {
    refuse(quoted + ": '" + hemisphere +
           "' is neither N nor S (write the hemisphere, not the latitude band)");
  }
  return utm(zone, hemisphere == 'N' || hemisphere == 'n');
}

std::string describe(const Frame& frame) {
  std::string units = frame.radians ? "radians" : "";
  if (frame.kilometres)
    units += units.empty() ? "kilometres" : ", kilometres";
  if (frame.depth_down)
    units += units.empty() ? "depth down" : ", depth down";
  const std::string depth = units.empty() ? "" : " (" + units + ")";
  switch (frame.kind) {
  case FrameKind::geocentric:
    return "geocentric";
  case FrameKind::geodetic:
    return "geodetic" + depth;
  case FrameKind::enu:
    return "enu [" + number(frame.longitude) + ", " + number(frame.latitude) + ", " +
           number(frame.height) + "]";
  case FrameKind::utm:
    return "utm " + std::to_string(frame.zone) + (frame.north ? "N" : "S") + depth;
  case FrameKind::cartesian:
    break;
  }
  return "cartesian";
}

void validate(const Frame& frame) {
  if (frame.kind == FrameKind::utm && (frame.zone < 1 || frame.zone > 60))
    refuse("utm zone " + std::to_string(frame.zone) + ": zones go from 1 to 60");
  if (frame.kind == FrameKind::enu) {
    if (!(std::abs(frame.latitude) <= 90))
      refuse("enu origin: latitude " + number(frame.latitude) + " is not in [-90, 90]");
    if (!(std::abs(frame.longitude) <= 540))
      refuse("enu origin: longitude " + number(frame.longitude) + " is not in [-540, 540]");
    if (!std::isfinite(frame.height))
      refuse("enu origin: height " + number(frame.height) + " is not finite");
  }
}

} // namespace insitu::geo
