#include "scene/parse/parse_parts.h"

namespace insitu::scene {
namespace {

ColorBy parse_color_by(const Cursor& cursor, const ParseContext& context) {
  ColorBy by;
  const MapReader map(cursor,
                      {"field", "component", "colors", "range", "scale", "below", "above", "nan"});
  if (const auto field = map.require("field")) {
    assign(by.field, parse_name(*field));
  }
  if (const auto component = map.find("component")) {
    by.component = parse_component(*component);
  }
  by.colors = parse_color_map(map, context);
  return by;
}

Isosurface parse_isosurface(const Cursor& cursor, const ParseContext& context) {
  Isosurface surface;
  surface.line = cursor.line();
  const MapReader map(cursor,
                      {"field", "component", "values", "opacity", "color", "normals", "search"});
  if (const auto field = map.require("field")) {
    assign(surface.field, parse_name(*field));
  }
  if (const auto component = map.find("component")) {
    surface.component = parse_component(*component);
  }
  if (const auto values = map.require("values")) {
    assign(surface.values, values->numbers(0));
    if (surface.values.size() > most_isovalues) {
      values->fail(std::to_string(surface.values.size()) + " isovalues, more than " +
                   std::to_string(most_isovalues));
    }
  }
  if (const auto opacity = map.find("opacity")) {
    assign(surface.opacity, opacity->number({0, 1}));
  }
  if (const auto color = map.find("color")) {
    if (color->is_map()) {
      surface.color = parse_color_by(*color, context);
    } else {
      surface.color = parse_color(*color, std::get<render::Color>(surface.color));
    }
  }
  if (const auto normals = map.find("normals")) {
    assign(surface.normals,
           normals->choice<render::Normals>({{"cell", render::Normals::cell},
                                             {"smooth", render::Normals::smooth},
                                             {"central", render::Normals::central}}));
  }
  if (const auto search = map.find("search")) {
    assign(surface.search,
           search->choice<render::RootSearch>({{"neubauer", render::RootSearch::neubauer},
                                               {"cubic", render::RootSearch::cubic},
                                               {"exact", render::RootSearch::exact}}));
  }
  return surface;
}

Body parse_body(const Cursor& cursor, const ParseContext& context) {
  Body body;
  body.line = cursor.line();
  const MapReader map(cursor, {"file", "opacity", "color"});
  if (const auto file = map.require("file")) {
    if (const auto path = file->text()) {
      body.path = resolve_path(*path, context.base_folder);
    }
  }
  if (const auto opacity = map.find("opacity")) {
    assign(body.opacity, opacity->number({0, 1}));
  }
  if (const auto color = map.find("color")) {
    body.color = parse_color(*color, body.color);
  }
  return body;
}

} // namespace

Boundary parse_boundary(const Cursor& cursor, const ParseContext& context) {
  Boundary boundary;
  const MapReader map(cursor, {"opacity", "color"});
  if (const auto opacity = map.find("opacity")) {
    assign(boundary.opacity, opacity->number({0, 1}));
  }
  if (const auto color = map.find("color")) {
    if (color->is_map()) {
      boundary.color = parse_color_by(*color, context);
    } else {
      boundary.color = parse_color(*color, std::get<render::Color>(boundary.color));
    }
  }
  return boundary;
}

std::vector<Body> parse_bodies(const Cursor& cursor, const ParseContext& context) {
  std::vector<Body> bodies;
  const auto items = cursor.items();
  for (const Cursor& item : items ? *items : std::vector<Cursor>{}) {
    bodies.push_back(parse_body(item, context));
  }
  return bodies;
}

BoxOutline parse_outline(const Cursor& cursor) {
  BoxOutline outline;
  const MapReader map(cursor, {"color", "width", "ticks"});
  if (const auto color = map.find("color")) {
    outline.color = parse_color(*color, outline.color);
  }
  if (const auto width = map.find("width")) {
    assign(outline.width, width->number({0, 100, true}));
  }
  if (const auto ticks = map.find("ticks")) {
    assign(outline.ticks, ticks->boolean());
  }
  return outline;
}

std::vector<Isosurface> parse_isosurfaces(const Cursor& cursor, const ParseContext& context) {
  std::vector<Isosurface> surfaces;
  const auto items = cursor.items();
  for (const Cursor& item : items ? *items : std::vector<Cursor>{}) {
    surfaces.push_back(parse_isosurface(item, context));
  }
  return surfaces;
}

} // namespace insitu::scene
