#include "scene/json_reader.hpp"

namespace assur {

// Names of points, members included: they tell an angle of points from one of vectors. Names of measured angles.
void JsonReader::remember_names(const JsonNode& scene) {
  const auto remember = [&](const JsonNode* points) {
    if (points != nullptr) point_names_.insert(points->keys().begin(), points->keys().end());
  };
  remember(scene.find("points"));
  if (const JsonNode* measures = scene.find("measures"); measures != nullptr) {
    for (std::size_t i = 0; i < measures->keys().size(); ++i) {
      if (measures->items()[i].find("angle") != nullptr) angle_names_.insert(measures->keys()[i]);
    }
  }
  const JsonNode* bodies = scene.find("bodies");
  if (bodies == nullptr) return;
  for (const JsonNode& body : bodies->items()) remember(body.find("points"));
}

void JsonReader::read_points(const JsonNode* section) {
  each(section, Where("/points"), [&](const std::string& name, const JsonNode& node, const Where& where) {
    Object item(*this, node, where, {"at", "fixed"});
    Point point{name, {}, false};
    const std::string_view needed = dimension_ == 3 ? "the position [x, y, z]" : "the position [x, y]";
    if (const JsonNode* at = item.need("at", needed)) point.at = triple(*at, where / "at");
    if (const JsonNode* fixed = item.find("fixed")) point.fixed = boolean(*fixed, where / "fixed");
    builder_.add(std::move(point));
  });
}

void JsonReader::read_vectors(const JsonNode* section) {
  each(section, Where("/vectors"), [&](const std::string& name, const JsonNode& node, const Where& where) {
    Object item(*this, node, where, {"at", "fixed", "unit"});
    Vector vector{name, {}, false, true};
    const std::string_view needed = dimension_ == 3 ? "the direction [x, y, z]" : "the direction [x, y]";
    if (const JsonNode* at = item.need("at", needed)) vector.at = triple(*at, where / "at");
    if (const JsonNode* fixed = item.find("fixed")) vector.fixed = boolean(*fixed, where / "fixed");
    if (const JsonNode* unit = item.find("unit")) vector.unit = boolean(*unit, where / "unit");
    builder_.add(std::move(vector));
  });
}

void JsonReader::read_bodies(const JsonNode* section) {
  each(section, Where("/bodies"), [&](const std::string& name, const JsonNode& node, const Where& where) {
    Body body;
    body.name = name;
    if (node.is(Type::object) && node.find("rigid") != nullptr) {
      note(where / "rigid",
           "\"rigid\" comes in a later format version; write a \"base\" and members with local coordinates");
      broken(where);
      builder_.add(std::move(body));
      return;
    }
    Object item(*this, node, where, {"origin", "frame", "base", "points", "vectors"});
    if (const JsonNode* origin = item.find("origin")) body.origin = text(*origin, where / "origin", "\"O\"");
    if (const JsonNode* frame = item.find("frame")) body.frame = texts(*frame, where / "frame", "\"u\"");
    if (const JsonNode* base = item.find("base")) body.base = texts(*base, where / "base", "\"A\"");
    if (const JsonNode* points = item.find("points")) read_members(points, where / "points", body.points);
    if (const JsonNode* vectors = item.find("vectors")) read_members(vectors, where / "vectors", body.vectors);
    builder_.add(std::move(body));
  });
}

void JsonReader::read_members(const JsonNode* section, const Where& where, std::vector<Member>& members) {
  each(section, where, [&](const std::string& name, const JsonNode& node, const Where& here) {
    if (!node.is(Type::object)) {
      members.push_back({name, triple(node, here)});
      return;
    }
    Object item(*this, node, here, {"at"});
    const JsonNode* at = item.need("at", "the ground coordinates in the posture as written");
    members.push_back({name, at ? triple(*at, here / "at") : Triple{}, true});
  });
}

void JsonReader::read_groups(const JsonNode* section) {
  each(section, Where("/groups"), [&](const std::string& name, const JsonNode& node, const Where& where) {
    Object item(*this, node, where, {"unknowns", "keep"});
    DeclaredGroup group;
    group.name = name;
    if (const JsonNode* unknowns = item.need("unknowns", "the names of points and vectors")) {
      group.unknowns = texts(*unknowns, where / "unknowns", "\"B\"");
    }
    if (const JsonNode* keep = item.find("keep")) group.keep = boolean(*keep, where / "keep");
    builder_.add(std::move(group));
  });
}

void JsonReader::read_outputs(const JsonNode* section) {
  if (section == nullptr) return;
  for (std::string& name : texts(*section, Where("/outputs"), "\"C\"")) builder_.output(std::move(name));
}

void JsonReader::read_time(const JsonNode* section) {
  if (section == nullptr) return;
  const Where where("/time");
  Object item(*this, *section, where, {"start", "end", "step"});
  const JsonNode* start = item.need("start", "the first time, s");
  const JsonNode* end = item.need("end", "the last time, s");
  const JsonNode* step = item.need("step", "from one time to the next, s");
  if (start == nullptr || end == nullptr || step == nullptr) return broken(where);
  const double first = number(*start, where / "start"), last = number(*end, where / "end");
  builder_.time(first, last, number(*step, where / "step"));
}

}  // namespace assur
