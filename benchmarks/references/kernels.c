/* The kernels of kinematics/closure/series.py and balance/space/momentum/regressor.py in C, loop by loop.
 *
 * Compiled as C it is the reference for run time; compiled as C++ with -DCOUNT it counts its
 * additions, multiplications and divisions. Arrays are contiguous, in the shapes of the Python
 * kernels; a link of -1 is the ground. Nothing is allocated.
 */
#include <math.h>
#include <string.h>

#ifdef COUNT
static long additions, multiplications, divisions;
struct real {
    double x;
    real(double x = 0.0) : x(x) {}
};
static real operator+(real a, real b) { additions++; return real(a.x + b.x); }
static real operator-(real a, real b) { additions++; return real(a.x - b.x); }
static real operator*(real a, real b) { multiplications++; return real(a.x * b.x); }
static real operator/(real a, real b) { divisions++; return real(a.x / b.x); }
static real operator-(real a) { return real(-a.x); }
static void operator+=(real &a, real b) { a = a + b; }
static void operator-=(real &a, real b) { a = a - b; }
static void operator*=(real &a, real b) { a = a * b; }
static void operator/=(real &a, real b) { a = a / b; }
#define API extern "C"
API void counted(long *out) {
    out[0] = additions, out[1] = multiplications, out[2] = divisions;
    additions = multiplications = divisions = 0;
}
#else
typedef double real;
#define API
#endif

/* Entries of the arrays, whose sizes are: rays, orders, n links, width, bodies. */
#define V(k, j) (V + (((long)ray * orders + (k)) * n + (j)) * DIM)
#define T(k, j, w) (T + ((((long)ray * orders + (k)) * n + (j)) * width + (w)) * DIM)
#define H(k) (H + (((long)ray * bodies + b) * orders + (k)) * HSIZE)
#define N(k) (N + ((((long)ray * bodies + b) * width + w) * orders + (k)) * NSIZE)
#define X(k) (X + ((((long)(k) * rays + ray) * width + w) * PER) * columns + b * SIZE)
#define x(i, c) x[(i) * columns + (c)]

/* balance.space.momentum.regressor._spatial at the reference pose, all orders, dynamic balance */
#define DIM 6
#define HSIZE 12
#define NSIZE 15
#define PER 6
#define SIZE 10

API void momentum_spatial(
    long rays, long orders, long n, long width, long bodies, const long *links,
    const char *moves, const real *V, const real *T, real *H, real *N, real *X
) {
    const long columns = bodies * SIZE;
    for (long ray = 0; ray < rays; ray++)
    for (long b = 0; b < bodies; b++) {
        const long j = links[b];
        if (j < 0)
            continue;
        for (int c = 0; c < 4; c++)
            for (int i = 0; i < 3; i++)
                H(0)[3 * c + i] = i == c ? 1.0 : 0.0;
        for (long k = 1; k < orders; k++) {
            real *h = H(k);
            for (int i = 0; i < 3; i++) {
                h[i] = h[3 + i] = h[6 + i] = 0.0;
                h[9 + i] = V(k - 1, j)[3 + i];
            }
            for (long a = 0; a < k; a++) {
                const real *v = V(a, j), *g = H(k - 1 - a);
                for (int c = 0; c < 12; c += 3) {
                    h[c] += v[1] * g[c + 2] - v[2] * g[c + 1];
                    h[c + 1] += v[2] * g[c] - v[0] * g[c + 2];
                    h[c + 2] += v[0] * g[c + 1] - v[1] * g[c];
                }
            }
            for (int c = 0; c < 12; c++)
                h[c] /= (double)k;
        }
        for (long w = 0; w < width; w++) {
            if (!moves[j * width + w])
                continue;
            for (long k = 0; k < orders; k++) {
                real *m = N(k), *x = X(k);
                const real *t = T(k, j, w);
                m[0] = 0.0, m[1] = t[2], m[2] = -t[1];
                m[3] = -t[2], m[4] = 0.0, m[5] = t[0];
                m[6] = t[1], m[7] = -t[0], m[8] = 0.0;
                for (int i = 0; i < 3; i++)
                    m[9 + i] = t[3 + i], m[12 + i] = t[i];
                for (long a = 1; a <= k; a++) {
                    const real *h = H(a);
                    t = T(k - a, j, w);
                    for (int c = 0; c < 4; c++) {
                        const real *g = h + 3 * c;
                        m[3 * c] += t[1] * g[2] - t[2] * g[1];
                        m[3 * c + 1] += t[2] * g[0] - t[0] * g[2];
                        m[3 * c + 2] += t[0] * g[1] - t[1] * g[0];
                        if (c < 3)
                            m[12 + c] += t[0] * g[0] + t[1] * g[1] + t[2] * g[2];
                    }
                }
                for (int i = 0; i < 3; i++) {
                    x(3 + i, 0) = m[9 + i];
                    for (int c = 0; c < 3; c++)
                        x(3 + i, 1 + c) = m[3 * c + i];
                }
                const real *e = m + 9, *y = m + 12;
                x(1, 3) += e[0], x(2, 1) += e[1], x(0, 2) += e[2];
                x(2, 2) -= e[0], x(0, 3) -= e[1], x(1, 1) -= e[2];
                for (int i = 0; i < 3; i++)
                    x(i, 4 + i) += y[i];
                x(0, 7) += y[1], x(1, 7) += y[0], x(0, 8) += y[2];
                x(2, 8) += y[0], x(1, 9) += y[2], x(2, 9) += y[1];
                for (long a = 1; a <= k; a++) {
                    const real *h = H(a);
                    m = N(k - a);
                    const real y0 = m[12], y1 = m[13], y2 = m[14];
                    for (int i = 0; i < 3; i++) {
                        const int u = (i + 1) % 3, v = (i + 2) % 3;
                        const real du = h[9 + u], dv = h[9 + v], eu = m[9 + u], ev = m[9 + v];
                        x(i, 0) += du * ev - dv * eu;
                        for (int c = 0; c < 9; c += 3)
                            x(i, 1 + c / 3) += h[c + u] * ev - h[c + v] * eu + du * m[c + v]
                                               - dv * m[c + u];
                        const real r0 = h[i], r1 = h[3 + i], r2 = h[6 + i];
                        x(i, 4) += r0 * y0;
                        x(i, 5) += r1 * y1;
                        x(i, 6) += r2 * y2;
                        x(i, 7) += r0 * y1 + r1 * y0;
                        x(i, 8) += r0 * y2 + r2 * y0;
                        x(i, 9) += r1 * y2 + r2 * y1;
                    }
                }
            }
        }
    }
}

/* balance.space.momentum.regressor._planar, likewise */
#undef DIM
#undef HSIZE
#undef NSIZE
#undef PER
#undef SIZE
#define DIM 3
#define HSIZE 4
#define NSIZE 4
#define PER 3
#define SIZE 4

API void momentum_planar(
    long rays, long orders, long n, long width, long bodies, const long *links,
    const char *moves, const real *V, const real *T, real *H, real *N, real *X
) {
    const long columns = bodies * SIZE;
    for (long ray = 0; ray < rays; ray++)
    for (long b = 0; b < bodies; b++) {
        const long j = links[b];
        if (j < 0)
            continue;
        H(0)[0] = 1.0, H(0)[1] = H(0)[2] = H(0)[3] = 0.0;
        for (long k = 1; k < orders; k++) {
            real gx = 0.0, gy = 0.0, dx = V(k - 1, j)[1], dy = V(k - 1, j)[2];
            for (long a = 0; a < k; a++) {
                const real omega = V(a, j)[0], *h = H(k - 1 - a);
                gx -= omega * h[1];
                gy += omega * h[0];
                dx -= omega * h[3];
                dy += omega * h[2];
            }
            real *h = H(k);
            const double order = k;
            h[0] = gx / order, h[1] = gy / order, h[2] = dx / order, h[3] = dy / order;
        }
        for (long w = 0; w < width; w++) {
            if (!moves[j * width + w])
                continue;
            for (long k = 0; k < orders; k++) {
                real nx = 0.0, ny = 0.0, ex = T(k, j, w)[1], ey = T(k, j, w)[2];
                for (long a = 0; a <= k; a++) {
                    const real omega = T(k - a, j, w)[0], *h = H(a);
                    nx -= omega * h[1];
                    ny += omega * h[0];
                    ex -= omega * h[3];
                    ey += omega * h[2];
                }
                real *m = N(k), *x = X(k);
                m[0] = nx, m[1] = ny, m[2] = ex, m[3] = ey;
                x(1, 0) = ex, x(1, 1) = nx, x(1, 2) = -ny;
                x(2, 0) = ey, x(2, 1) = ny, x(2, 2) = nx;
                x(0, 3) = T(k, j, w)[0];
                for (long a = 0; a <= k; a++) {
                    const real *h = H(a), *g = N(k - a);
                    x(0, 0) += h[2] * g[3] - h[3] * g[2];
                    x(0, 1) += h[0] * g[3] - h[1] * g[2] + h[2] * g[1] - h[3] * g[0];
                    x(0, 2) += h[2] * g[0] + h[3] * g[1] - h[0] * g[2] - h[1] * g[3];
                }
            }
        }
    }
}

/* kinematics.closure.series._planar_series along one ray with one coordinate and no mimics, in the
 * workspace of the caller: A (rows, dependent), diagonal and b. */
static void bracket(const real *v, const real *s, real factor, real *out) {
    out[1] += factor * (s[0] * v[2] - v[0] * s[2]);
    out[2] += factor * (v[0] * s[1] - s[0] * v[1]);
}

static void factorise(real *A, long rows, long columns, real *diagonal) {
    for (long k = 0; k < columns; k++) {
        real norm = 0.0;
        for (long i = k; i < rows; i++)
            norm += A[i * columns + k] * A[i * columns + k];
#ifdef COUNT
        norm = real(sqrt(norm.x));
        if (A[k * columns + k].x > 0.0)
#else
        norm = sqrt(norm);
        if (A[k * columns + k] > 0.0)
#endif
            norm = -norm;
        diagonal[k] = norm;
        A[k * columns + k] -= norm;
        for (long j = k + 1; j < columns; j++) {
            real dot = 0.0;
            for (long i = k; i < rows; i++)
                dot += A[i * columns + k] * A[i * columns + j];
            dot /= norm * A[k * columns + k];
            for (long i = k; i < rows; i++)
                A[i * columns + j] += dot * A[i * columns + k];
        }
    }
}

static void solve(const real *A, long rows, long columns, const real *diagonal, real *b) {
    for (long k = 0; k < columns; k++) {
        real dot = 0.0;
        for (long i = k; i < rows; i++)
            dot += A[i * columns + k] * b[i];
        dot /= diagonal[k] * A[k * columns + k];
        for (long i = k; i < rows; i++)
            b[i] += dot * A[i * columns + k];
    }
    for (long k = columns - 1; k >= 0; k--) {
        for (long j = k + 1; j < columns; j++)
            b[k] -= A[k * columns + j] * b[j];
        b[k] /= diagonal[k];
    }
}

API void closure_planar(
    long orders, long n, const long *parent, const real *screws, long loops, const long *ends,
    long count, const long *dependent, const real *columns, real *A, real *diagonal, real *b,
    real *extra, real *S, real *C, real *V, real *T
) {
    const long ray = 0, rows = 3 * loops, width = 1;
    memset(A, 0, rows * count * sizeof(real));
    memset(S, 0, orders * n * 3 * sizeof(real));
    memset(C, 0, orders * n * sizeof(real));
    memset(V, 0, orders * n * 3 * sizeof(real));
    memset(T, 0, orders * n * 3 * sizeof(real));
    for (long loop = 0; loop < loops; loop++)
        for (int side = 0; side < 2; side++)
            for (long j = ends[2 * loop + side]; j >= 0; j = parent[j])
                for (long c = 0; c < count; c++)
                    if (dependent[c] == j)
                        for (int i = 0; i < 3; i++)
                            A[(3 * loop + i) * count + c] += (1.0 - 2.0 * side) * screws[3 * j + i];
    factorise(A, rows, count, diagonal);
    for (long k = 0; k < orders; k++) {
        for (long j = 0; j < n; j++) {
            real *s = S + (k * n + j) * 3;
            if (k == 0)
                for (int i = 0; i < 3; i++)
                    s[i] = screws[3 * j + i];
            else if (parent[j] >= 0)
                for (long a = 0; a < k; a++)
                    bracket(V(a, parent[j]), S + ((k - 1 - a) * n + j) * 3, 1.0 / k, s);
        }
        for (long j = 0; j < n; j++) {
            real *t = T(k, j, 0);
            if (parent[j] >= 0)
                for (int i = 0; i < 3; i++)
                    t[i] = T(k, parent[j], 0)[i];
            if (k == 0)
                C[j] = columns[j];
            for (long a = k > 0; a <= k; a++)
                for (int i = 0; i < 3; i++)
                    t[i] += S[(a * n + j) * 3 + i] * C[(k - a) * n + j];
        }
        for (long loop = 0; loop < loops; loop++)
            for (int i = 0; i < 3; i++) {
                const long e = ends[2 * loop], f = ends[2 * loop + 1];
                b[3 * loop + i] = 0.0;
                if (e >= 0)
                    b[3 * loop + i] -= T(k, e, 0)[i];
                if (f >= 0)
                    b[3 * loop + i] += T(k, f, 0)[i];
            }
        solve(A, rows, count, diagonal, b);
        for (long c = 0; c < count; c++)
            C[k * n + dependent[c]] = b[c];
        for (long j = 0; j < n; j++) {
            const real rate = C[k * n + j] - (k == 0 ? columns[j] : (real)0.0);
            for (int i = 0; i < 3; i++) {
                extra[3 * j + i] = screws[3 * j + i] * rate;
                if (parent[j] >= 0)
                    extra[3 * j + i] += extra[3 * parent[j] + i];
                T(k, j, 0)[i] += extra[3 * j + i];
                V(k, j)[i] += T(k, j, 0)[i];
            }
        }
    }
}

/* Both kernels, again and again: what the rate of answers is compared with. */
API void kernels_planar(
    long repetitions, long orders, long n, const long *parent, const real *screws, long loops,
    const long *ends, long count, const long *dependent, const real *columns, real *work,
    long bodies, const long *links, const char *moves, real *X
) {
    real *A = work, *diagonal = A + 3 * loops * count, *b = diagonal + count;
    real *extra = b + 3 * loops, *S = extra + 3 * n, *C = S + 3 * orders * n;
    real *V = C + orders * n, *T = V + 3 * orders * n, *H = T + 3 * orders * n;
    real *N = H + 4 * orders * bodies;
    for (long r = 0; r < repetitions; r++) {
        closure_planar(orders, n, parent, screws + 3 * n * r, loops, ends, count, dependent,
                       columns, A, diagonal, b, extra, S, C, V, T);
        memset(X, 0, orders * 3 * bodies * 4 * sizeof(real));
        momentum_planar(1, orders, n, 1, bodies, links, moves, V, T, H, N, X);
    }
}
