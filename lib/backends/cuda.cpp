#include "backends/cuda.hpp"

#include <array>

#include "assur/status.hpp"
#include "backends/shared_library.hpp"
#include "decimal.hpp"

namespace assur::cuda {
namespace {

// The names of the libraries of each version of CUDA, the newest first.
struct Release {
  const char *runtime, *blas, *solver;
};
constexpr std::array kReleases = {Release{"libcudart.so.13", "libcublas.so.13", "libcusolver.so.12"},
                                  Release{"libcudart.so.12", "libcublas.so.12", "libcusolver.so.11"},
                                  Release{"libcudart.so.11.0", "libcublas.so.11", "libcusolver.so.11"}};
constexpr const char* kDriver = "libcuda.so.1";

#define ASSUR_FIND(NAME) in.find(#NAME, out.NAME)

void find_runtime(SharedLibrary& in, Library& out) {
  ASSUR_FIND(cudaGetDeviceCount);
  ASSUR_FIND(cudaDriverGetVersion);
  ASSUR_FIND(cudaRuntimeGetVersion);
  ASSUR_FIND(cudaMemGetInfo);
  ASSUR_FIND(cudaMalloc);
  ASSUR_FIND(cudaFree);
  ASSUR_FIND(cudaMallocHost);
  ASSUR_FIND(cudaFreeHost);
  ASSUR_FIND(cudaStreamCreateWithFlags);
  ASSUR_FIND(cudaStreamDestroy);
  ASSUR_FIND(cudaStreamSynchronize);
  ASSUR_FIND(cudaMemcpyAsync);
  ASSUR_FIND(cudaMemcpy2DAsync);
  ASSUR_FIND(cudaEventCreate);
  ASSUR_FIND(cudaEventDestroy);
  ASSUR_FIND(cudaEventRecord);
  ASSUR_FIND(cudaEventElapsedTime);
  ASSUR_FIND(cudaGetLastError);
  ASSUR_FIND(cudaGetErrorString);
}

void find_blas(SharedLibrary& in, Library& out) {
  ASSUR_FIND(cublasCreate_v2);
  ASSUR_FIND(cublasDestroy_v2);
  ASSUR_FIND(cublasSetStream_v2);
  in.find("cublasDgetrfBatched", out.in_double.getrf_batched);
  in.find("cublasSgetrfBatched", out.in_float.getrf_batched);
  in.find("cublasDgetrsBatched", out.in_double.getrs_batched);
  in.find("cublasSgetrsBatched", out.in_float.getrs_batched);
  in.find("cublasDcopy_v2", out.in_double.copy);
  in.find("cublasScopy_v2", out.in_float.copy);
}

void find_solver(SharedLibrary& in, Library& out) {
  ASSUR_FIND(cusolverGetVersion);
  ASSUR_FIND(cusolverDnCreate);
  ASSUR_FIND(cusolverDnDestroy);
  ASSUR_FIND(cusolverDnSetStream);
  in.find("cusolverDnDgetrf_bufferSize", out.in_double.getrf_size);
  in.find("cusolverDnSgetrf_bufferSize", out.in_float.getrf_size);
  in.find("cusolverDnDgetrf", out.in_double.getrf);
  in.find("cusolverDnSgetrf", out.in_float.getrf);
  in.find("cusolverDnDgetrs", out.in_double.getrs);
  in.find("cusolverDnSgetrs", out.in_float.getrs);
}

#undef ASSUR_FIND

// CUDA writes 12.4 as 12040.
std::string version_text(int version) {
  return std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
}

std::string why_no_device(const Library& cuda) {
  int devices = 0, driver = 0, runtime = 0;
  const int status = cuda.cudaGetDeviceCount(&devices);
  if (status == 0 && devices > 0) return "";
  cuda.cudaDriverGetVersion(&driver);
  cuda.cudaRuntimeGetVersion(&runtime);
  if (status == kOldDriver) {
    return "the NVIDIA driver is too old: it supports CUDA " + version_text(driver) +
           ", and the libraries are those of " + version_text(runtime) +
           "; update the driver, or install an older CUDA";
  }
  return "the NVIDIA driver offers no device (" +
         std::string(status == 0 ? "no device is visible" : cuda.cudaGetErrorString(status)) +
         "); nvidia-smi lists devices, and CUDA_VISIBLE_DEVICES may hide them";
}

// The name of the first device, by the driver; "" if it does not tell.
std::string device_name() {
  SharedLibrary in;
  int (*get)(int* device, int number) = nullptr;
  int (*name)(char* name, int size, int device) = nullptr;
  if (!in.open(kDriver)) return "";
  in.find("cuDeviceGet", get);
  in.find("cuDeviceGetName", name);
  std::array<char, 256> text{};
  int device = 0;
  const bool told =
      get && name && get(&device, 0) == 0 && name(text.data(), static_cast<int>(text.size()) - 1, device) == 0;
  return told ? text.data() : "";
}

std::string version_of(const Library& cuda) {
  int runtime = 0, solver = 0;
  cuda.cudaRuntimeGetVersion(&runtime);
  cuda.cusolverGetVersion(&solver);  // 11401 is 11.4.1
  const std::string name = device_name();
  return "CUDA " + version_text(runtime) + ", cuSOLVER " + std::to_string(solver / 1000) + "." +
         std::to_string(solver % 1000 / 100) + "." + std::to_string(solver % 100) + (name.empty() ? "" : ", " + name);
}

Library load_release(const Release& names) {
  Library out{};
  SharedLibrary in;
  if (!in.open(names.runtime)) return out;
  find_runtime(in, out);
  out.why_not = in.complete() ? why_no_device(out) : in.missing();  // before the larger libraries are loaded
  if (!out.why_not.empty()) return out;
  for (const char* const name : {names.blas, names.solver}) {
    if (!in.open(name)) {
      out.why_not = std::string(names.runtime) + " was found without " + name +
                    "; install this part of CUDA too, or put its folder into LD_LIBRARY_PATH";
      return out;
    }
    name == names.blas ? find_blas(in, out) : find_solver(in, out);
  }
  out.why_not = in.missing();
  if (in.complete()) out.version = version_of(out);
  return out;
}

Library load() {
  Library first{};
  if (first.why_not = why_no_driver(); !first.why_not.empty()) return first;
  for (const Release& names : kReleases) {
    Library found = load_release(names);
    if (found.why_not.empty() && !found.version.empty()) return found;
    if (first.why_not.empty()) first.why_not = found.why_not;
  }
  if (first.why_not.empty()) {
    first.why_not =
        "no CUDA libraries were found (libcudart, libcublas and libcusolver of CUDA 11, 12 or 13): install CUDA, and "
        "put the folder of its libraries into LD_LIBRARY_PATH";
  }
  return first;
}

}  // namespace

const std::string& why_no_driver() {
  static const std::string kWhyNot =
      SharedLibrary().open(kDriver)
          ? ""
          : std::string("no NVIDIA driver (") + kDriver +
                ") was found: cusolver needs an NVIDIA GPU, its driver, and the libraries of CUDA 11, 12 or 13";
  return kWhyNot;
}

const Library& library() {
  static const Library loaded = load();
  return loaded;
}

void check(int status, const char* function) {
  if (status == 0) return;
  throw Error(Error::Kind::environment,
              std::string("cusolver: ") + function + " failed with status " + std::to_string(status));
}

void check_cuda(int status, const char* function) {
  if (status == 0) return;
  library().cudaGetLastError();  // else a later call reports this failure again
  throw Error(Error::Kind::environment,
              std::string("cusolver: ") + function + " failed: " + library().cudaGetErrorString(status));
}

std::string mebibytes(double bytes) { return fixed(bytes / (1 << 20), 0) + " MiB"; }

void* allocate(Where where, std::size_t bytes) {
  const bool device = where == Where::device;
  void* memory = nullptr;
  const int status = (device ? library().cudaMalloc : library().cudaMallocHost)(&memory, bytes);
  if (status != kNoMemory) check_cuda(status, device ? "cudaMalloc" : "cudaMallocHost");
  if (status == 0) return memory;
  library().cudaGetLastError();
  throw Error(Error::Kind::environment, std::string(device ? "the GPU" : "the computer") + " has no memory for " +
                                            mebibytes(static_cast<double>(bytes)) +
                                            " of dense factors; use fewer lanes or a sparse backend");
}

void release(Where where, void* memory) noexcept {
  if (memory) (where == Where::device ? library().cudaFree : library().cudaFreeHost)(memory);
}

Queue::Queue() : Queue(Nothing{}) {
  const Library& cuda = library();
  check_cuda(cuda.cudaStreamCreateWithFlags(&stream_, kNonBlocking), "cudaStreamCreateWithFlags");
  check(cuda.cublasCreate_v2(&blas_), "cublasCreate");
  check(cuda.cublasSetStream_v2(blas_, stream_), "cublasSetStream");
  check(cuda.cusolverDnCreate(&solver_), "cusolverDnCreate");
  check(cuda.cusolverDnSetStream(solver_, stream_), "cusolverDnSetStream");
}

Queue::~Queue() {
  if (solver_) library().cusolverDnDestroy(solver_);
  if (blas_) library().cublasDestroy_v2(blas_);
  if (stream_) library().cudaStreamDestroy(stream_);
}

void Queue::copy(void* to, const void* from, std::size_t bytes, int kind) const {
  check_cuda(library().cudaMemcpyAsync(to, from, bytes, kind, stream_), "cudaMemcpyAsync");
}

void Queue::wait() const { check_cuda(library().cudaStreamSynchronize(stream_), "cudaStreamSynchronize"); }

Marks::Marks() : Marks(Nothing{}) {
  for (void*& event : events_) check_cuda(library().cudaEventCreate(&event), "cudaEventCreate");
}

Marks::~Marks() {
  for (void* const event : events_) {
    if (event) library().cudaEventDestroy(event);
  }
}

void Marks::set(std::size_t mark, const Queue& queue) const {
  check_cuda(library().cudaEventRecord(events_[mark], queue.stream()), "cudaEventRecord");
}

double Marks::seconds(std::size_t mark) const {
  float milliseconds = 0;
  check_cuda(library().cudaEventElapsedTime(&milliseconds, events_[mark], events_[mark + 1]), "cudaEventElapsedTime");
  return 1e-3 * milliseconds;
}

}  // namespace assur::cuda
