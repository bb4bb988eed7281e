// Embree behind four C functions, so that one program can time it and our own engine on the same rays in one run.
//
// One rtcIntersect1 or rtcOccluded1 per ray, many rays per call, as Embree's documentation recommends for incoherent
// rays: FTZ and DAZ on, medium build quality (its default), no filters.

#include <embree3/rtcore.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <pmmintrin.h>
#include <xmmintrin.h>

namespace {

struct Ray {
    float origin[3], direction[3], t_min, t_max;
};

struct Scene {
    RTCDevice device;
    RTCScene scene;
};

// Flushes denormals to zero for as long as it lives.
class FlushDenormals {
    unsigned before = _mm_getcsr();

public:
    FlushDenormals() {
        _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
        _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
    }
    ~FlushDenormals() { _mm_setcsr(before); }
};

void fill(RTCRay &out, const Ray &ray) {
    out.org_x = ray.origin[0];
    out.org_y = ray.origin[1];
    out.org_z = ray.origin[2];
    out.dir_x = ray.direction[0];
    out.dir_y = ray.direction[1];
    out.dir_z = ray.direction[2];
    out.tnear = ray.t_min;
    out.tfar = ray.t_max;
    out.time = 0;
    out.mask = ~0u;
    out.flags = 0;
}

} // namespace

extern "C" {

Scene *embree_build(const float *triangles, size_t count, int robust, unsigned threads) {
    FlushDenormals flush;
    RTCDevice device = rtcNewDevice(threads == 1 ? "threads=1" : "threads=2");
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto *vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * count);
    std::memcpy(vertices, triangles, 36 * count);
    auto *indices = static_cast<uint32_t *>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count));
    for (size_t i = 0; i < 3 * count; ++i)
        indices[i] = uint32_t(i);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    return new Scene{device, scene};
}

void embree_release(Scene *scene) {
    rtcReleaseScene(scene->scene);
    rtcReleaseDevice(scene->device);
    delete scene;
}

// Distances of the closest hits, infinite for a miss.
void embree_closest(const Scene *scene, const Ray *rays, size_t count, float *t) {
    FlushDenormals flush;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (size_t i = 0; i < count; ++i) {
        RTCRayHit hit;
        fill(hit.ray, rays[i]);
        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene->scene, &context, &hit);
        t[i] = hit.hit.geomID == RTC_INVALID_GEOMETRY_ID ? __builtin_inff() : hit.ray.tfar;
    }
}

void embree_occluded(const Scene *scene, const Ray *rays, size_t count, bool *occluded) {
    FlushDenormals flush;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (size_t i = 0; i < count; ++i) {
        RTCRay ray;
        fill(ray, rays[i]);
        rtcOccluded1(scene->scene, &context, &ray);
        occluded[i] = ray.tfar < 0;
    }
}
}
