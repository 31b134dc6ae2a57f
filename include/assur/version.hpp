// The version of assur as macros, also for C. CMakeLists.txt reads it from here.
#pragma once

#define ASSUR_VERSION_MAJOR 0
#define ASSUR_VERSION_MINOR 1
#define ASSUR_VERSION_PATCH 0
#define ASSUR_VERSION "0.1.0"
