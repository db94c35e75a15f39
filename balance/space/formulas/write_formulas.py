"""Formulas as text."""
from __future__ import annotations

from balance.space.formulas.formula_data import Formulas
def text(f):
    names=[]
    for i,conj in f.free.variables:
        d=f.parts.dimensions[i]
        n=d.name if d.kind!="offset" else f"(i {d.name})"
        names.append(f"conj({n})" if conj else n)
    def mono(e):
        return [n if k==1 else f"{n}^{k}" for n,k in zip(names,e) if k]
    def poly(P):
        out=""
        for e in sorted(P,reverse=True):
            c=P[e]; m=" ".join(mono(e))
            a=abs(c)
            t=m if a==1 and m else f"{a} {m}".strip()
            out+=(" - " if c<0 else " + ")+t if out else ("-" if c<0 else "")+t
        return out
    def quo(q):
        up=[];down=[]
        if abs(q.content.numerator)!=1: up.append(str(abs(q.content.numerator)))
        if q.content.denominator!=1: down.append(str(q.content.denominator))
        for n,k in zip(names,q.monomial):
            if k>0: up.append(n if k==1 else f"{n}^{k}")
            if k<0: down.append(n if k==-1 else f"{n}^{-k}")
        for P,k in q.factors:
            t=f"({poly(P)})"+(f"^{abs(k)}" if abs(k)>1 else "")
            (up if k>0 else down).append(t)
        u=" ".join(up) or ("1" if down else "")
        if down:
            d=" ".join(down)
            return f"({u}/{d})" if len(down)==1 else f"({u}/({d}))"
        return u
    lines=[]
    for c in f.conditions:
        s=c.solved.name
        for t in c.terms:
            q=quo(t.coefficient)
            s+=(" - " if t.coefficient.content<0 else " + ")+(q+" " if q else "")+t.parameter.name
        lines.append(s+" = 0")
    return "\n".join(lines)
