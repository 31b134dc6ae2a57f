// Models in MJCF, the format of MuJoCo, as scenes. docs/mjcf.md lists the elements that are read and those that are
// left out. The functions in this header need the library assur::assur.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "assur/scene.hpp"

namespace assur {

// Choices that a model leaves open.
struct ModelOptions {
  std::string key = {};  // name of the keyframe at which the motion starts; "": at the posture of the model (qpos0)
  // Joints and their laws, which count from the posture as written (of the model, or of the keyframe), in rad or m: a
  // law of the scene format, the coefficients of a polynomial of t ("0,6.28"), or "free" for an actuated joint that is
  // not to be driven.
  std::vector<std::pair<std::string, std::string>> drive = {};
  // Folders for the tables of these laws, besides that of the model.
  std::vector<std::filesystem::path> tables = {};
};

// A scene made of a model.
struct ImportedModel {
  // A hinge or slide.
  struct Coordinate {
    std::string joint;  // name in the model, or the one given to it
    std::string name;   // in the scene: "hip.angle", "leg.displacement"; 0 in the posture as written
    double start = 0;   // the value of MuJoCo (qpos) in the posture as written: qpos = start + coordinate; rad or m
    bool driven = false;
  };
  struct Driver {
    // In the scene: the name of its actuator or joint equality, or JOINT_drive if it has no name or if
    // ModelOptions::drive drives a joint without an actuator.
    std::string name;
    std::string coordinate;  // Coordinate::name of its joint
    // True if no law was given: it stands still, unless PrepareOptions::controlled names it and the program sets it.
    bool controlled = true;
  };

  std::string name;                     // of the model
  Scene scene;                          // write_scene() writes it as a file
  std::size_t bodies = 0;               // moving bodies; a body without joints is a part of another one
  std::size_t joints = 0;               // of the model
  std::size_t loops = 0;                // closed by connect, weld and joint equalities
  std::vector<Coordinate> coordinates;  // in the order of the model
  std::vector<Driver> drivers;          // of the scene
  std::vector<std::pair<std::string, std::size_t>>
      left_out;                    // kinds of elements without a meaning here, and their numbers
  std::vector<std::string> notes;  // sentences: names that were changed, loops that had to be closed
};

// Reads a model: regular files of at most 16 MB in all, whose includes lie in or below the folder of the first one.
// Throws Error: environment if a file cannot be read, or if assur was built without tinyxml2; input, with file, line
// and name, if something is wrong or is not understood.
[[nodiscard]] ImportedModel import_model(const std::filesystem::path& file, const ModelOptions& options = {});

// True if the name of the file ends with .xml: open_scene() then reads a model.
[[nodiscard]] bool is_model(const std::filesystem::path& file);

}  // namespace assur
