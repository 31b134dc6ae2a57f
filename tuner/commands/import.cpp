#include "assur/mjcf.hpp"

#include <iostream>

#include "commands/commands.hpp"
#include "output/format.hpp"
#include "output/json.hpp"
#include "output/page.hpp"
#include "output/replace_file.hpp"

namespace assur::command {
namespace {

using output::counted;
using output::grouped;
using output::Json;

Json summary_of(const ImportedModel& model, const ImportOptions& options) {
  Json left_out = Json::array(), drivers = Json::array(), coordinates = Json::array();
  for (const auto& [kind, count] : model.left_out) left_out.push_back({{"kind", kind}, {"count", count}});
  for (const ImportedModel::Driver& d : model.drivers) {
    drivers.push_back({{"name", d.name}, {"coordinate", d.coordinate}, {"controlled", d.controlled}});
  }
  for (const ImportedModel::Coordinate& c : model.coordinates) {
    coordinates.push_back({{"joint", c.joint}, {"coordinate", c.name}, {"start", c.start}, {"driven", c.driven}});
  }
  return {{"scene", model.name},        {"bodies", model.bodies}, {"joints", model.joints},
          {"loops", model.loops},       {"left_out", left_out},   {"drivers", drivers},
          {"coordinates", coordinates}, {"notes", model.notes},   {"out", output::or_null(options.out)}};
}

void print_summary(const ImportedModel& model, const ImportOptions& options) {
  output::Page page(std::cout);
  page.title(model.name + ": " + grouped(model.bodies) + (model.bodies == 1 ? " moving body, " : " moving bodies, ") +
             counted(model.joints, "joint") + ", " + counted(model.loops, "loop"));
  std::vector<std::string> driven, controlled, open, left_out;
  for (const ImportedModel::Driver& d : model.drivers) {
    (d.controlled ? controlled : driven).push_back(d.coordinate + " (" + d.name + ")");
  }
  for (const ImportedModel::Coordinate& c : model.coordinates) {
    if (!c.driven) open.push_back(c.joint);
  }
  for (const auto& [kind, count] : model.left_out) {
    left_out.push_back(kind + (count > 1 ? " (" + grouped(count) + ")" : ""));
  }
  if (!driven.empty()) page.fact("driven", output::listed(driven));
  if (!controlled.empty())
    page.fact("controlled", output::listed(controlled) + "; at rest until --drive or a program moves them");
  if (!open.empty()) page.fact("not driven", output::listed(open));
  if (!left_out.empty()) page.fact("left out", output::listed(left_out));
  page.list("note", model.notes);
  page.fact("scene", options.out.empty() ? "not written; --out FILE writes it" : options.out);
}

ImportedModel import(const Common& common, const std::string& file) {
  ModelOptions options = common.model;
  options.tables = common.tables;
  return import_model(file, options);
}

}  // namespace

Scene open(const Common& common, const std::string& scene, const Parameters& set, bool moves) {
  if (!is_model(scene)) {
    for (const auto& [option, given] :
         {std::pair("--key", !common.model.key.empty()), std::pair("--drive", !common.model.drive.empty())}) {
      if (given) refuse(option, "is for models of MuJoCo, files that end with .xml");
    }
    return open_scene(scene, set, common.tables);
  }
  if (!set.empty()) throw Error(Error::Kind::input, {{"--set", "a model of MuJoCo has no parameters"}}, scene);
  const ImportedModel model = import(common, scene);
  if (moves && model.drivers.empty()) {
    std::vector<std::string> joints;
    for (const ImportedModel::Coordinate& c : model.coordinates) joints.push_back(c.joint);
    throw Error(Error::Kind::input,
                {{"", "no joint is driven, so that nothing moves" +
                          (joints.empty() ? ", and the model has no hinge or slide"
                                          : "; choose with --drive JOINT=LAW among: " + output::listed(joints))}},
                scene);
  }
  return model.scene;
}

int import_scene(const Common& common, const ImportOptions& options) {
  refuse_overwriting(common, {{"--out", options.out}}, {options.file});
  if (!is_model(options.file)) {
    throw Error(Error::Kind::input, {{"", "a model of MuJoCo is wanted here, a file that ends with .xml"}},
                options.file);
  }
  const ImportedModel model = import(common, options.file);
  refuse_overwriting({{"--out", options.out}}, model.scene);
  if (!options.out.empty()) {
    output::Replacement out("--out", options.out);
    out.stream() << write_scene(model.scene);
    out.put();
  }
  if (common.json) {
    output::print(std::cout, summary_of(model, options));
  } else {
    print_summary(model, options);
  }
  return kDone;
}

}  // namespace assur::command
